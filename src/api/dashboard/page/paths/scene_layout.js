// What the coordinator tells of a job's scene: where its camera and its lights stand, and which place a pixel shows.

import { Problem, ask, expect, send } from '../connection/api.js';

// By job; what is asked for once stays as it is.
const layouts = new Map();

// Where camera and lights stand. A request that failed is sent again when it is asked for again.
export function layoutOf(job) {
  if (!layouts.has(job.id)) {
    const asked = ask(`/v1/jobs/${job.id}/layout`);
    asked.catch(() => layouts.delete(job.id));
    layouts.set(job.id, asked);
  }
  return layouts.get(job.id);
}

// Where nothing is seen, depth is this or more.
const NOTHING = 1e10;

// The place of the first surface that a pixel shows, m.
export async function placeAt(job, { x, y }) {
  const numbers = async layer => {
    const address = `/v1/jobs/${job.id}/pixels?layer=${layer}&x=${x}&y=${y}&width=1&height=1`;
    return new Float32Array(await (await expect(await send(address))).arrayBuffer());
  };
  const [[depth], place] = [await numbers('depth'), await numbers('position')];
  if (depth >= NOTHING) throw new Problem({ detail: 'Nothing is seen there.', remedy: 'Choose a place with a surface.' });
  return [...place];
}
