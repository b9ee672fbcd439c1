// Sends a scene, and tells how much of it is on its way. `fetch` cannot tell that, so this is an XMLHttpRequest.

import { Problem } from '../connection/api.js';

// Answers what the coordinator knows of the scene; `tell` is called with the share that is sent.
export function upload(blob, tell) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', '/v1/scenes');
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    request.upload.onprogress = event => tell(event.lengthComputable ? event.loaded / event.total : 0);
    request.onerror = () =>
      reject(
        new Problem({
          detail: 'The upload broke off.',
          remedy: 'Check that the coordinator answers and that the scene is not larger than it takes; then try again.',
        }),
      );
    request.onload = () => {
      const answer = parse(request.responseText);
      if (request.status === 201) resolve(answer);
      else reject(new Problem({ detail: `The coordinator answers ${request.status}.`, ...answer }));
    };
    request.send(blob);
  });
}

function parse(text) {
  try {
    return JSON.parse(text);
  } catch {
    return {};
  }
}
