// What engine_reference wrote: a clip, a walk, and what the native stream makes of them.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

/**
 * Largest difference of a sample that is still rounding: native kernels may fuse multiplications and additions, and the C
 * libraries round exponentials and sines differently in the last bit.
 */
export const TOLERANCE = 1e-4;

function floats(path) {
  const bytes = readFileSync(path);
  return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
}

/** Of [2][samples], both. */
const ears = (planar) => [planar.subarray(0, planar.length / 2), planar.subarray(planar.length / 2)];

export function readRecording(folder) {
  const about = JSON.parse(readFileSync(join(folder, 'about.json')));
  return {
    ...about,
    sound: ears(floats(join(folder, 'sound.f32'))),
    heard: ears(floats(join(folder, 'heard.f32'))),
    places: floats(join(folder, 'places.f32')),
    picture: { width: about.width, height: about.height, data: new Uint8Array(readFileSync(join(folder, 'picture.rgb'))) },
  };
}

/** Where the earpoint is in a block. */
export function poseAt(recording, block) {
  const [x, y, z, yawDeg, pitchDeg, rollDeg] = recording.places.subarray(6 * block, 6 * block + 6);
  return { x, y, z, yawDeg, pitchDeg, rollDeg };
}

/** A stream for the recording, knowing all that the native one knew. */
export function openStream(engine, recording) {
  const stream = engine.stream({ sampleRate: recording.sampleRate });
  stream.placeSpeaker(recording.speaker);
  stream.see(recording.picture, recording.speakerBox);
  return stream;
}

/** Runs a stream along the walk, block by block. */
export function walk(stream, recording, pose = poseAt) {
  const heard = recording.sound.map((ear) => new Float32Array(ear.length));
  for (let start = 0; start < recording.samples; start += recording.block) {
    stream.moveTo(pose(recording, start / recording.block));
    const cut = (ear) => ear.subarray(start, start + recording.block);
    stream.process(recording.sound.map(cut), heard.map(cut));
  }
  return heard;
}

export function largestDifference(a, b) {
  let largest = 0;
  a.forEach((ear, index) => {
    for (let i = 0; i < ear.length; ++i) {
      const difference = Math.abs(ear[i] - b[index][i]);
      if (!(difference <= largest)) largest = difference; // NaN counts as a difference
    }
  });
  return largest;
}

export const peak = (sound) => largestDifference(sound, sound.map((ear) => new Float32Array(ear.length)));
