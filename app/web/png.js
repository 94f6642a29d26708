// The header of a PNG, read before anything is sent.

const GREY = 0;

/**
 * @param {Blob} file
 * @returns {Promise<{rows: number, columns: number, bitDepth: number, grey: boolean} | null>} null if it is not a PNG
 */
export async function readHeader(file) {
  const bytes = new DataView(await file.slice(0, 26).arrayBuffer());
  if (bytes.byteLength < 26 || bytes.getUint32(0) !== 0x89504e47) return null;
  return {
    columns: bytes.getUint32(16),
    rows: bytes.getUint32(20),
    bitDepth: bytes.getUint8(24),
    grey: bytes.getUint8(25) === GREY,
  };
}
