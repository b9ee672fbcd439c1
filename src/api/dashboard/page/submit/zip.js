// Makes a zip archive of files as they are, without compressing them: the browser reads each once for its checksum, and then the archive refers to
// it, so a large folder needs no memory. The format is that of PKWARE's APPNOTE 6.3.

const UTF8_NAMES = 0x0800;
const VERSION = 20;
// 1 January 1980, the first day that the format knows: the same files make the same archive.
const DATE = 0x21;

const CHECKSUMS = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

// CRC-32 of bytes that follow others.
export function checksum(bytes, before = 0) {
  let value = ~before;
  for (const byte of bytes) value = CHECKSUMS[(value ^ byte) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}

async function checksumOf(file) {
  let sum = 0;
  const reader = file.stream().getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) sum = checksum(part.value, sum);
  return sum;
}

// `files` is a list of `{ name, file }`; `comment` stands at the end of the archive.
export async function zip(files, comment = '', tell = () => {}) {
  const [parts, directory] = [[], []];
  let offset = 0;
  for (const [index, { name, file }] of files.entries()) {
    tell(index, name);
    const entry = { name: new TextEncoder().encode(name), sum: await checksumOf(file), size: file.size, offset };
    const header = numbers([[0x04034b50, 4], ...common(entry), [entry.name.length, 2], [0, 2]]);
    parts.push(header, entry.name, file);
    offset += header.length + entry.name.length + file.size;
    const rest = [
      [entry.name.length, 2],
      [0, 2],
      [0, 2],
      [0, 2],
      [0, 2],
      [0, 4],
      [entry.offset, 4],
    ];
    directory.push(numbers([[0x02014b50, 4], [VERSION, 2], ...common(entry), ...rest]), entry.name);
  }
  const size = directory.reduce((sum, part) => sum + part.length, 0);
  const text = new TextEncoder().encode(comment);
  const end = [
    [0x06054b50, 4],
    [0, 2],
    [0, 2],
    [files.length, 2],
    [files.length, 2],
    [size, 4],
    [offset, 4],
    [text.length, 2],
  ];
  return new Blob([...parts, ...directory, numbers(end), text], { type: 'application/zip' });
}

// What both headers of a file have in common. Method 0 stores it as it is.
const common = ({ sum, size }) => [
  [VERSION, 2],
  [UTF8_NAMES, 2],
  [0, 2],
  [0, 2],
  [DATE, 2],
  [sum, 4],
  [size, 4],
  [size, 4],
];

// Little-endian numbers, each with its count of bytes.
function numbers(fields) {
  return Uint8Array.from(fields.flatMap(([value, bytes]) => Array.from({ length: bytes }, (_, index) => (value >>> (8 * index)) & 255)));
}
