// The files of a scene: what was dropped or chosen, and what of it is uploaded. A lone file goes as it is; everything else becomes a zip archive.

import { zip } from './zip.js';

// As the coordinator reads them.
export const FORMATS = ['xml', 'json', 'gltf', 'glb', 'mgf', 'pbrt', 'zip'];
// By this comment an archive says which of its files is the scene.
const SCENE_COMMENT = 'photonfarm scene: ';

const extension = name => name.split('.').pop().toLowerCase();

// All files of a drop, folders with what is in them, as `{ name, file }` with names below what was dropped.
export async function droppedFiles(transfer) {
  // Only entries know folders, and what no file manager dropped has none.
  const entries = [...transfer.items].map(item => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return chosenFiles(transfer.files);
  const files = (await Promise.all(entries.map(entry => filesOf(entry, '')))).flat();
  return withoutCommonFolder(files);
}

export const chosenFiles = list => withoutCommonFolder([...list].map(file => ({ name: file.webkitRelativePath || file.name, file })));

async function filesOf(entry, folder) {
  if (entry.isFile) return [{ name: folder + entry.name, file: await new Promise((resolve, reject) => entry.file(resolve, reject)) }];
  const reader = entry.createReader();
  const entries = [];
  // A reader answers some entries at a time, and none at the end.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) break;
    entries.push(...some);
  }
  return (await Promise.all(entries.map(child => filesOf(child, `${folder}${entry.name}/`)))).flat();
}

// Hidden files are no part of a scene.
export function withoutCommonFolder(files) {
  const seen = files.filter(({ name }) => !name.split('/').some(part => part.startsWith('.')));
  const [first] = seen[0]?.name.split('/') ?? [];
  const isCommon = seen.every(({ name }) => name.startsWith(`${first}/`));
  return isCommon ? seen.map(({ name, file }) => ({ name: name.slice(first.length + 1), file })) : seen;
}

// Which files may be the scene: those at the top, or where there are none, any.
export function sceneCandidates(files) {
  const scenes = files.map(({ name }) => name).filter(name => FORMATS.includes(extension(name)) && extension(name) !== 'zip');
  const top = scenes.filter(name => !name.includes('/'));
  const standard = top.filter(name => name.startsWith('scene.'));
  return standard.length === 1 ? standard : top.length ? top : scenes;
}

// What is uploaded: a lone file, or all files in an archive that names the scene among them.
export async function packed(files, scene, tell) {
  if (files.length === 1) return files[0].file;
  return zip(files, SCENE_COMMENT + scene, tell);
}
