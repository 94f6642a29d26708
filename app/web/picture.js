// The height map on a canvas, and contact masks on a second one over it.

import { file } from "./api.js";

const heights = document.getElementById("heights");
const overlay = document.getElementById("overlay");

/** Decode a PNG without colour management. @returns {Promise<ImageBitmap>} */
export const decode = (blob) => createImageBitmap(blob, { colorSpaceConversion: "none" });

/** Load a mask. @returns {Promise<ImageBitmap>} */
export const loadMask = async (url) => decode(await file(url));

export function clearPicture() {
  for (const canvas of [heights, overlay]) canvas.hidden = true;
}

function pixels(bitmap) {
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext("2d");
  context.drawImage(bitmap, 0, 0);
  return context.getImageData(0, 0, bitmap.width, bitmap.height);
}

function colour(name) {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((start) => parseInt(hex.slice(start, start + 2), 16));
}

/**
 * Draw grey heights from the darkest to the lightest tone, stretched over the levels that the map uses.
 * @returns {{lowest: number, highest: number}} those levels, from 0 to 1
 */
export function drawHeights(bitmap) {
  const image = pixels(bitmap);
  const { data } = image;
  let lowest = 255;
  let highest = 0;
  for (let i = 0; i < data.length; i += 4) {
    lowest = Math.min(lowest, data[i]);
    highest = Math.max(highest, data[i]);
  }
  const [dark, light] = [colour("--low"), colour("--high")];
  for (let i = 0; i < data.length; i += 4) {
    const height = (data[i] - lowest) / (highest - lowest || 1);
    for (let channel = 0; channel < 3; channel++) {
      data[i + channel] = dark[channel] + height * (light[channel] - dark[channel]);
    }
  }
  put(heights, image);
  overlay.hidden = true;
  return { lowest: lowest / 255, highest: highest / 255 };
}

/** Draw pixels of contact: predicted, reference, or where the two differ. */
export function drawMasks(predicted, reference) {
  const image = pixels(predicted ?? reference);
  const inPredicted = predicted ? image.data.slice() : null;
  const inReference = reference ? pixels(reference).data : null;
  const both = colour("--touch");
  const onlyPredicted = colour("--only-predicted");
  const onlyReference = colour("--only-reference");
  for (let i = 0; i < image.data.length; i += 4) {
    const p = inPredicted ? inPredicted[i] > 0 : inReference[i] > 0;
    const r = inReference ? inReference[i] > 0 : p;
    const shade = p && r ? both : p ? onlyPredicted : onlyReference;
    image.data.set([...shade, p || r ? 255 : 0], i);
  }
  put(overlay, image);
}

function put(canvas, image) {
  canvas.width = image.width;
  canvas.height = image.height;
  canvas.getContext("2d").putImageData(image, 0, 0);
  canvas.hidden = false;
}

/** Show pixels in their physical shape: width over height of the map, fitted to the window. */
export function setShape(ratio) {
  for (const canvas of [heights, overlay]) {
    canvas.style.aspectRatio = ratio;
    canvas.style.width = `min(100%, calc(74vh * ${ratio}))`;
  }
}

export function setOpacity(share) {
  overlay.style.opacity = share;
}

/** Width of the drawn map, in CSS pixels. */
export const drawnWidth = () => heights.clientWidth;
