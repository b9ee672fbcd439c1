// A shared worker: it holds the one stream of events for all tabs of a browser, which has only six connections for each host. It lives as long as
// any of them does, so no tab leads and none is missed when it is closed.

import { FarmStream } from './farm_stream.js';

const pages = new Set();
const stream = new FarmStream(message => pages.forEach(page => page.postMessage(message)));

self.onconnect = ({ ports: [page] }) => {
  pages.add(page);
  page.onmessage = ({ data }) => {
    if (data === 'leave') pages.delete(page);
    if (data === 'open') stream.open();
  };
  stream.messages().forEach(message => page.postMessage(message));
  if (!stream.source) stream.open();
};
