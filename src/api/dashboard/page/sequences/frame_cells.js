// The frames of a sequence as cells in a row. A pure function.

// The last ones of a long sequence, so that the page stays quick.
const MOST = 1000;

// The frames that are jobs by now, in order.
export function frameCells({ frames }, jobs) {
  const cells = jobs.map(({ id, state, frame }) => ({ number: frame.number, state, job: id }));
  const inOrder = cells.filter(({ number }) => number >= frames.first && number <= frames.last).sort((one, other) => one.number - other.number);
  return inOrder.slice(-MOST);
}
