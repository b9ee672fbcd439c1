// Small pictures of the jobs that are listed. They are asked for one after the other, only for rows that are seen, and only when there is something
// new; the browser keeps them with their tags and is told when they did not change.

import { send } from '../connection/api.js';
import { isLive } from '../store.js';
import { decodeHalf } from '../viewer/half.js';
import { paintColor } from '../viewer/paint.js';
import { toneTable } from '../viewer/tone.js';
import { hasEnded } from './progress.js';
import { THUMBNAIL } from './row.js';

// One running job's row gets a new picture this often at most, of several each so much more seldom: making it costs the coordinator something.
const REFRESH_MS = 15000;
// Rows that are only passed by while scrolling are not asked for.
const REST_MS = 250;
const KEPT = 400;
const TABLE = toneTable({ curve: 'srgb', exposure: 0, gamma: 1 });

const kept = new Map();
let wanted = [];
let drawn = () => {};
let timer = null;
let isBusy = false;

// Asks for the pictures of these jobs; `tell` is called with the id of each that came.
export function wantThumbnails(jobs, tell) {
  wanted = jobs;
  drawn = tell;
  if (!isBusy) timer ??= setTimeout(work, REST_MS);
}

export function drawThumbnail(canvas, id) {
  const context = canvas.getContext('2d');
  context.clearRect(0, 0, canvas.width, canvas.height);
  const picture = kept.get(id)?.picture;
  if (!picture) return;
  const scale = Math.min(canvas.width / picture.width, canvas.height / picture.height);
  const [width, height] = [picture.width * scale, picture.height * scale];
  context.drawImage(picture, (canvas.width - width) / 2, (canvas.height - height) / 2, width, height);
}

async function work() {
  [timer, isBusy] = [null, true];
  for (let job = next(); job && !document.hidden && isLive(); job = next()) await load(job);
  isBusy = false;
}

function next() {
  const running = wanted.filter(job => !hasEnded(job)).length;
  const isDue = job => {
    const old = kept.get(job.id);
    if (!job.passes_done || old?.version === job.picture_version) return false;
    return !old || hasEnded(job) || performance.now() - old.at > REFRESH_MS * running;
  };
  return wanted.find(isDue);
}

async function load(job) {
  const level = Math.max(Math.ceil(Math.log2(Math.max(job.width / THUMBNAIL.width, job.height / THUMBNAIL.height))), 0);
  const address = `/v1/jobs/${job.id}/pixels?level=${level}&format=half`;
  // The browser sends the tag of what it keeps.
  const answer = await send(address, { cache: 'no-cache' }).catch(() => null);
  const old = kept.get(job.id);
  kept.delete(job.id);
  kept.set(job.id, { picture: old?.picture, version: job.picture_version, at: performance.now() });
  if (!answer?.ok) return;
  kept.get(job.id).picture = paint(answer.headers, new Uint16Array(await answer.arrayBuffer()));
  if (kept.size > KEPT) kept.delete(kept.keys().next().value);
  drawn(job.id);
}

function paint(headers, bits) {
  const [width, height] = ['width', 'height'].map(name => Number(headers.get(`photonfarm-${name}`)));
  const canvas = new OffscreenCanvas(width, height);
  const image = new ImageData(width, height);
  paintColor(decodeHalf(bits), TABLE, new Uint32Array(image.data.buffer));
  canvas.getContext('2d').putImageData(image, 0, 0);
  return canvas;
}
