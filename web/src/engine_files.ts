import { Clip, ClipList, fetchEngine, fetchModel, fetchPicture, fetchRecording } from './api';
import type { Scene } from './playback';

const LONGEST_S = 300; // of a clip that the page holds in its memory: 115 MB at 48 kHz

/** What the page's own engine needs for a clip. */
export interface EngineFiles {
  sound: Float32Array[];
  scene: Scene;
  module: WebAssembly.Module;
  /** The methods that it renders, and the model of each; without one: the recording. */
  models: Map<string, Uint8Array | undefined>;
}

/** Where the sound is rendered: by the page, as soon as its files are there, or by the server, and why. */
export type EngineChoice = { files: Promise<EngineFiles>; isForced: boolean } | { why: string };

async function pixelsOf(picture: Blob): Promise<ImageData> {
  // As they are: no colour is to be adapted to the screen.
  const bitmap = await createImageBitmap(picture, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
  const canvas = document.createElement('canvas');
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  const pen = canvas.getContext('2d', { willReadFrequently: true })!;
  pen.drawImage(bitmap, 0, 0);
  return pen.getImageData(0, 0, bitmap.width, bitmap.height);
}

async function sceneOf(clip: Clip): Promise<Scene> {
  const pixels = clip.has_picture ? await pixelsOf(await fetchPicture(clip.id)) : null;
  return {
    fov_deg: clip.fov_deg,
    picture: pixels && { width: pixels.width, height: pixels.height, data: pixels.data },
    speaker_box: (pixels && clip.speaker_box) ?? null,
    speaker_m: clip.speaker_m ?? null,
  };
}

async function fetchFiles(clip: Clip): Promise<EngineFiles> {
  const methods = clip.methods.filter(({ browser, missing }) => browser && !missing);
  const [sound, scene, module, models] = await Promise.all([
    fetchRecording(clip.id),
    sceneOf(clip),
    fetchEngine().then((bytes) => WebAssembly.compile(bytes)),
    Promise.all(methods.map(({ name, browser }) => (browser === 'model' ? fetchModel(name) : undefined))),
  ]);
  return { sound, scene, module, models: new Map(methods.map(({ name }, i) => [name, models[i]])) };
}

/** @param wish  `browser` or `server`, as `?engine=` in the page's address has it; null: the browser if it can */
export function chooseEngine(clip: Clip, { has_engine }: ClipList, wish: string | null): EngineChoice {
  const isForced = wish === 'browser';
  if (wish === 'server') return { why: 'as the address asks' };
  if (!has_engine) return { why: 'it was built without the engine for browsers' };
  if (clip.duration_s > LONGEST_S && !isForced) return { why: 'the clip is long' };
  const files = fetchFiles(clip);
  files.catch(() => {}); // whoever waits for them says what failed
  return { files, isForced };
}
