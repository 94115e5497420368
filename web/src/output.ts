import { SampleQueue } from './queue';

const SCRIPT_SAMPLES = 1024; // that the page's main thread supplies at once

/** Plays sound, left and right interleaved. */
export interface Output {
  readonly node: AudioNode;
  /** Called with the number of samples that were played so far. */
  onplayed: (samples: number) => void;
  push(part: Float32Array): void;
  clear(): void;
}

async function openWorklet(context: AudioContext): Promise<Output> {
  await context.audioWorklet.addModule('worklet.js');
  const node = new AudioWorkletNode(context, 'queue', { numberOfInputs: 0, outputChannelCount: [2] });
  const output: Output = {
    node,
    onplayed: () => {},
    push: (part) => node.port.postMessage(part, [part.buffer]),
    clear: () => node.port.postMessage('clear'),
  };
  node.port.onmessage = (event) => output.onplayed(event.data as number);
  return output;
}

function openScript(context: AudioContext): Output {
  const queue = new SampleQueue();
  const node = context.createScriptProcessor(SCRIPT_SAMPLES, 0, 2);
  const output: Output = {
    node, onplayed: () => {}, push: (part) => queue.push(part), clear: () => queue.clear(),
  };
  node.onaudioprocess = ({ outputBuffer }) => {
    const before = queue.played;
    queue.fill(outputBuffer.getChannelData(0), outputBuffer.getChannelData(1));
    if (queue.played !== before) output.onplayed(queue.played);
  };
  return output;
}

/**
 * Connects an output to the context's destination. Browsers have worklets only on pages of this computer or by HTTPS:
 * with `--host`, the page's main thread supplies the sound.
 */
export async function openOutput(context: AudioContext): Promise<Output> {
  const output = context.audioWorklet ? await openWorklet(context) : openScript(context);
  output.node.connect(context.destination);
  return output;
}
