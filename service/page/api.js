/** Asking the service. Addresses are relative to the page, so that it works under any path. */

import { capital } from "./words.js";

/** Why there is no answer: the service's own sentence, or ours where it could not be reached. */
export class Problem extends Error {}

/** What was found in pictures of one object, after so many iterations of refinement: { report, glb }, the GLB as an
 * ArrayBuffer. */
export async function reconstruct(pictures, category, refine) {
  const response = await ask("v1/reconstruct", "application/json", { body: form(pictures, category, refine) });
  return scene(await response.json());
}

/** That mesh over the first of the pictures, a Blob of image/png. */
export async function overlay(pictures, category, refine) {
  const response = await ask("v1/reconstruct", "image/png", { body: form(pictures, category, refine) });
  return response.blob();
}

/** A new object, turned by `side` degrees: { report, glb }. */
export async function sample(category, seed, temperature, side) {
  return answer("v1/sample", { category, seed, temperature, azimuth_degrees: side });
}

/** The object of a shape code, turned by `side` degrees: { report, glb }. */
export async function decode(category, shapeCode, side) {
  return answer("v1/decode", { category, z: spelled(shapeCode), azimuth_degrees: side });
}

/** The object on the way `t`, 0 to 1, from one seed's to another's, turned by `side` degrees: { report, glb }. */
export async function interpolate(category, fromSeed, toSeed, t, temperature, side) {
  const seeds = { from_seed: fromSeed, to_seed: toSeed };
  return answer("v1/interpolate", { category, ...seeds, t, temperature, azimuth_degrees: side });
}

/** A picture, a PNG in a Blob, of a new object that is turned by `side` degrees. */
export async function painted(category, seed, temperature, side) {
  const response = await ask(samplePicture(category, seed, temperature, side), "image/png", {});
  return response.blob();
}

/** The address of a picture of a new object that is turned by `side` degrees, for an <img>. */
export function samplePicture(category, seed, temperature, side) {
  return address("v1/sample", { category, seed, temperature, azimuth_degrees: side });
}

/** The address of a picture of a report's object, turned by `side` degrees, for an <img>. */
export function shapePicture({ category, shape_code: shapeCode }, side) {
  return address("v1/decode", { category, z: spelled(shapeCode), azimuth_degrees: side });
}

/** What the service's models are, in alphabetical order. */
export async function categories() {
  const response = await ask("v1/categories", "application/json", {});
  const { categories: models } = await response.json();
  return models;
}

async function answer(path, query) {
  const response = await ask(address(path, query), "application/json", {});
  return scene(await response.json());
}

function address(path, query) {
  return `${path}?${new URLSearchParams(query)}`;
}

function spelled(shapeCode) {
  return shapeCode.map((value) => value.toFixed(4)).join(",");
}

async function ask(path, accept, { body }) {
  let response;
  try {
    const method = body === undefined ? "GET" : "POST";
    response = await fetch(path, { method, body, headers: { Accept: accept } });
  } catch {
    throw new Problem("Expected an answer of the service, found no connection; see whether it still runs.");
  }
  if (response.ok) return response;
  throw new Problem(await sentence(response));
}

async function sentence(response) {
  const isProblem = response.headers.get("content-type")?.startsWith("application/problem+json");
  const detail = isProblem ? (await response.json()).detail : `found status ${response.status}; try again`;
  return `${capital(detail)}${detail.endsWith(".") ? "" : "."}`;
}

function form(pictures, category, refine) {
  const data = new FormData();
  for (const picture of pictures) data.append("image", picture, picture.name ?? "picture");
  data.append("category", category);
  data.append("refine", refine);
  return data;
}

function scene({ glb_base64: encoded, ...report }) {
  return { report, glb: Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0)).buffer };
}
