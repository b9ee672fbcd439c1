// Follows the farm: by the worker that all tabs share, or by a stream of its own in a browser without shared workers.

import { FarmStream } from './farm_stream.js';

// Calls `hear` with every message; the answer opens the stream anew, as after a login.
export function followFarm(build, hear) {
  if (!globalThis.SharedWorker) {
    const stream = new FarmStream(hear);
    stream.open();
    return () => stream.open();
  }
  // Another build of the coordinator may bring another worker, so each has a name of its own.
  const worker = new SharedWorker('/page/connection/shared_stream.js', { type: 'module', name: `photonfarm ${build}` });
  worker.port.onmessage = ({ data }) => hear(data);
  addEventListener('pagehide', () => worker.port.postMessage('leave'));
  // A page that the browser kept aside was left out of what happened since.
  addEventListener('pageshow', event => event.persisted && location.reload());
  return () => worker.port.postMessage('open');
}
