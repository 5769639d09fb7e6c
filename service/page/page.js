/** The page: which part talks to which. */

import { Problem, categories, decode, interpolate, overlay, painted, reconstruct, sample } from "./api.js";
import { createGallery } from "./gallery.js";
import { createWay } from "./interpolation.js";
import { createNewest } from "./newest.js";
import { createResult } from "./result.js";
import { createSliders } from "./shape.js";
import { createStage } from "./stage.js";
import { receivePictures } from "./upload.js";
import { decimal, element, listed, one } from "./words.js";

const AUTO = "auto";
const SEEDS = 10000;
// Nearer to the middle of what the model knows than chance would have it.
const EXAMPLE_TEMPERATURE = 0.7;
// More of them gain next to nothing.
const ITERATIONS = 4;

// The azimuth, degrees, in which shapes are shown: from the front, and a little from the side.
const SIDE = 40;

const find = (id) => document.getElementById(id);

function tell(sentence) {
  calm();
  find("status").textContent = sentence;
}

function fail(error) {
  // A fault of the page itself belongs into the console, and the visitor still has to know.
  if (!(error instanceof Problem)) console.error(error);
  find("status").textContent = "";
  find("problem").textContent =
    error instanceof Problem ? error.message : "The page failed where it should not; load it again.";
  find("problem").hidden = false;
  find("problem").scrollIntoView({ block: "nearest" });
}

function calm() {
  find("problem").hidden = true;
}

function pick(count) {
  return Math.floor(Math.random() * count);
}

function startPicture(models, vary) {
  const show = createResult(find("result"), vary);
  const run = createNewest(fail, find("result"), calm);
  const [category, refine] = [find("category"), find("refine")];
  let latest = [];

  async function look(pictures) {
    latest = pictures;
    tell(pictures.length === 1 ? "Looking at the picture …" : `Looking at ${pictures.length} pictures …`);
    const begun = performance.now();
    try {
      const iterations = refine.checked ? ITERATIONS : 0;
      const answer = await reconstruct(pictures, category.value, iterations);
      const elapsed = performance.now() - begun;
      const over = await overlay(pictures, answer.report.category, iterations);
      show({ ...answer, pictures, elapsed, overlay: over });
      tell(`Found ${one(answer.report.category)}.`);
    } catch (error) {
      // What is there belongs to another picture.
      find("result").hidden = true;
      throw error;
    }
  }

  async function lookAndGo(pictures) {
    await look(pictures);
    find("result-title").focus();
  }

  receivePictures(find("files"), find("upload"), (pictures) => run(() => lookAndGo(pictures)));
  for (const choice of [category, refine]) {
    choice.addEventListener("change", () => {
      if (latest.length > 0) run(() => look(latest));
    });
  }
  find("example").addEventListener("click", () =>
    run(async () => {
      const names = category.value === AUTO ? models.map((model) => model.category) : [category.value];
      const name = names[pick(names.length)];
      const [seed, side] = [pick(SEEDS), pick(360) - 180];
      await lookAndGo([await painted(name, seed, EXAMPLE_TEMPERATURE, side)]);
    }),
  );
}

function startInvention(models) {
  const stage = createStage(find("bench-stage"));
  const run = createNewest(fail, find("bench"), calm);
  const [kind, seed, temperature] = [find("kind"), find("seed"), find("temperature")];
  let address = "";

  function show({ report, glb }, words) {
    URL.revokeObjectURL(address);
    address = URL.createObjectURL(new Blob([glb], { type: "model/gltf-binary" }));
    find("bench-download").href = address;
    find("bench-download").download = `${report.category}.glb`;
    find("bench-words").textContent = words;
    stage({ report, glb }, `The mesh of ${one(report.category)}: ${words}`);
  }

  const startSliders = createSliders(find("sliders"), find("undo"), (shapeCode) =>
    run(async () => show(await decode(kind.value, shapeCode, SIDE), "A shape of your own")),
  );
  function vary({ report, glb }, words) {
    if (kind.value !== report.category) {
      kind.value = report.category;
      refill();
    }
    gallery.mark(report.seed);
    show({ report, glb }, words);
    startSliders(report.shape_code, models.find((model) => model.category === report.category).latent_order);
  }

  const choose = (chosen) =>
    run(async () => vary(await sample(kind.value, chosen, temperature.value, SIDE), `Sample ${chosen}`));
  const gallery = createGallery(find("gallery"), choose);
  function refill() {
    if (seed.checkValidity()) gallery.fill(kind.value, seed.valueAsNumber, temperature.value, SIDE);
  }
  function redraw() {
    if (!seed.reportValidity()) return;
    refill();
    choose(seed.valueAsNumber);
  }
  kind.addEventListener("change", redraw);
  seed.addEventListener("change", redraw);
  temperature.addEventListener("change", redraw);
  temperature.addEventListener("input", () => {
    find("temperature-value").value = decimal(temperature.valueAsNumber);
  });
  find("reseed").addEventListener("click", () => {
    seed.value = pick(SEEDS);
    redraw();
  });
  find("draw").addEventListener("submit", (event) => event.preventDefault());

  createWay(find("from"), find("to"), find("way"), find("way-value"), (fromSeed, toSeed, t) =>
    run(async () =>
      vary(
        await interpolate(kind.value, fromSeed, toSeed, t, temperature.value, SIDE),
        `Between sample ${fromSeed} and ${toSeed}`,
      ),
    ),
  );
  redraw();
  return vary;
}

function offer(select, field, options) {
  select.replaceChildren(...options.map(([value, words]) => element("option", { value }, words)));
  field.hidden = options.length < 2;
}

async function start() {
  const models = await categories();
  const names = models.map((model) => model.category);
  const kinds = names.map((name) => [name, name]);
  offer(find("category"), find("category-field"), names.length > 1 ? [[AUTO, "let the models tell"], ...kinds] : kinds);
  offer(find("kind"), find("kind-field"), kinds);
  find("models").textContent =
    `Models here: ${listed(models.map((model) => `${model.category} (${model.model.slice(0, 8)})`))}.`;
  const vary = startInvention(models);
  startPicture(models, vary);
}

start().catch(fail);
