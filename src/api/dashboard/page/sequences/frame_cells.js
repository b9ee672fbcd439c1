// The frames of a sequence as cells in a row. A pure function.

// Of a long sequence the last ones that have begun, and as many that have not, so that the page stays quick.
const MOST = 500;

// All frames in order, each with its job where it is one by now.
export function frameCells({ frames, frames_total: total }, jobs) {
  const made = new Map(jobs.map(job => [job.frame.number, job]));
  const newest = Math.max(frames.first - 1, ...made.keys());
  const first = Math.max(frames.first, newest - MOST + 1);
  const last = Math.min(frames.first + total - 1, newest + MOST);
  return Array.from({ length: last - first + 1 }, (_, index) => {
    const job = made.get(first + index);
    return { number: first + index, state: job?.state ?? 'not there', job: job?.id };
  });
}
