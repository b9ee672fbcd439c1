// How much watching may cost: what is refreshed is paid for by a pause, so that an open page takes no more than this from the coordinator.

const BYTES_PER_SECOND = 1.5e6;
// Also an answer without bytes is work for the coordinator.
const LEAST_PAUSE_MS = 250;

let restedAt = 0;

// Milliseconds until something may be refreshed.
export const pause = () => Math.max(restedAt - performance.now(), 0);

// Notes that so many bytes came.
export function spend(bytes) {
  restedAt = Math.max(restedAt, performance.now()) + Math.max((1000 * bytes) / BYTES_PER_SECOND, LEAST_PAUSE_MS);
}
