// One layer of one job's picture, in tiles as they come from the coordinator: first all of it coarsely, then the tiles that are seen, at the
// level that the zoom needs. Tiles that are there are refreshed when there are new passes, one after the other and within the budget.

import { send } from '../connection/api.js';
import { pause, spend } from './budget.js';
import { TILE, atLevel } from './geometry.js';
import { decodeHalf } from './half.js';
import { LIGHT_GROUPS, mixVersion, mixed } from './light_groups.js';

// Tiles that are not seen any more are kept up to this many; fewer of light groups, which are larger.
const KEPT = 96;
const RETRY_MS = 2000;
const COLOR = ['R', 'G', 'B'];

const keyOf = ({ level, x, y, format }) => [level, x, y, format].join('/');

export class PictureSource {
  // `tell` is called when something came or failed.
  constructor(job, layer, tell) {
    Object.assign(this, { id: job.id, size: { width: job.width, height: job.height }, layer, tell });
    this.tiles = new Map();
    this.wanted = [];
    this.problem = '';
    const level = Math.max(Math.ceil(Math.log2(Math.max(job.width, job.height) / TILE)), 0);
    // Small pictures are wanted as exactly as they can be had.
    this.coarse = { level, x: 0, y: 0, format: level === 0 ? 'float' : 'half' };
  }

  close() {
    this.isClosed = true;
    clearTimeout(this.timer);
  }

  // Says which tiles are seen, and in which version the job's picture is.
  want(seen, version) {
    this.wanted = [this.coarse, ...seen];
    this.version = version;
    this.work();
  }

  async work() {
    if (this.isBusy || this.isClosed || document.hidden || !this.version) return;
    this.isBusy = true;
    for (let address = this.next(); address && !this.isClosed; address = this.next()) await this.load(address);
    this.isBusy = false;
  }

  // What is missing comes first and at once; what is old waits for its turn.
  next() {
    clearTimeout(this.timer);
    const tileOf = address => this.tiles.get(keyOf(address));
    if (performance.now() < this.retryAt) return this.wake(this.retryAt - performance.now());
    const missing = this.wanted.find(address => !tileOf(address));
    if (missing) return missing;
    const old = this.wanted.filter(address => tileOf(address).version !== this.version);
    if (!old.length) return null;
    if (pause() > 0) return this.wake(pause());
    return old.reduce((first, address) => (tileOf(address).askedAt < tileOf(first).askedAt ? address : first));
  }

  wake(milliseconds) {
    this.timer = setTimeout(() => this.work(), milliseconds);
    return null;
  }

  async load(address) {
    const { level, x, y, format } = address;
    const { version } = this;
    const old = this.tiles.get(keyOf(address));
    const whole = atLevel(this.size, level);
    const [width, height] = [Math.min(TILE, whole.width - x * TILE), Math.min(TILE, whole.height - y * TILE)];
    const query = new URLSearchParams({ layer: this.layer, level, x: x * TILE, y: y * TILE, width, height, format });
    const headers = old ? { 'If-None-Match': old.tag } : {};
    const answer = await send(`/v1/jobs/${this.id}/pixels?${query}`, { headers, cache: 'no-store' }).catch(() => null);
    const askedAt = performance.now();
    if (answer?.status === 304) {
      Object.assign(old, { version, askedAt });
      return spend(0);
    }
    if (!answer?.ok) return this.fail(answer);
    const bytes = await answer.arrayBuffer();
    spend(bytes.byteLength);
    const values = format === 'half' ? decodeHalf(new Uint16Array(bytes)) : new Float32Array(bytes);
    const channels = answer.headers.get('photonfarm-channels').split(',');
    const passes = Number(answer.headers.get('photonfarm-passes'));
    this.problem = '';
    const tile = { ...address, width, height, raw: { values, channels }, passes, tag: answer.headers.get('etag'), version, askedAt };
    this.keep({ ...tile, ...this.shown(tile.raw) });
  }

  // Values and channels as they are shown: of light groups, those of the picture that they make.
  shown({ values, channels }) {
    return this.layer === LIGHT_GROUPS ? { values: mixed(values, channels), channels: COLOR, mix: mixVersion() } : { values, channels };
  }

  // Light groups are to be shown in another way.
  remix() {
    if (this.layer !== LIGHT_GROUPS) return;
    for (const tile of this.tiles.values()) Object.assign(tile, this.shown(tile.raw), { scale: null });
  }

  keep(tile) {
    const key = keyOf(tile);
    this.tiles.delete(key);
    this.tiles.set(key, tile);
    const needed = new Set(this.wanted.map(keyOf));
    const most = (KEPT * COLOR.length) / Math.max(tile.raw.channels.length, COLOR.length);
    for (const other of this.tiles.keys()) {
      if (this.tiles.size <= most) break;
      if (!needed.has(other)) this.tiles.delete(other);
    }
    if (!this.isClosed) this.tell();
  }

  async fail(answer) {
    const problem = answer && (await answer.json().catch(() => ({})));
    const seconds = Number(answer?.headers.get('retry-after')) || RETRY_MS / 1000;
    this.retryAt = performance.now() + 1000 * seconds;
    // Without an answer the page says so elsewhere; before the first pass there is nothing to say.
    this.problem = answer && answer.status !== 404 ? [problem.detail, problem.remedy].filter(Boolean).join('; ') : '';
    if (!this.isClosed) this.tell();
  }

  // All of the picture at the coarse level, once it is there.
  get overview() {
    return this.tiles.get(keyOf(this.coarse));
  }

  same(tile) {
    return this.tiles.get(keyOf(tile));
  }

  // What there is to draw, coarse below fine.
  drawable(finest) {
    const rank = tile => [-tile.level, tile.format === 'float' ? 1 : 0];
    const drawn = [...this.tiles.values()].filter(tile => tile.level >= finest);
    return drawn.sort((one, other) => rank(one)[0] - rank(other)[0] || rank(one)[1] - rank(other)[1]);
  }

  // The finest value that is known of a pixel: its channels, and over how many pixels they are means.
  valueAt({ x, y }) {
    if (x < 0 || y < 0 || x >= this.size.width || y >= this.size.height) return null;
    const holds = tile => {
      const [column, row] = [Math.floor(x / 2 ** tile.level) - tile.x * TILE, Math.floor(y / 2 ** tile.level) - tile.y * TILE];
      return column >= 0 && row >= 0 && column < tile.width && row < tile.height ? { tile, column, row } : null;
    };
    const found = this.drawable(0).reverse().map(holds).find(Boolean);
    if (!found) return null;
    const { tile, column, row } = found;
    const at = (row * tile.width + column) * tile.channels.length;
    return { values: [...tile.values.slice(at, at + tile.channels.length)], channels: tile.channels, level: tile.level, format: tile.format };
  }
}
