import { Order, Playback, Report } from './playback';

const SCRIPT_SAMPLES = 1024; // that the page's main thread supplies at once

/** Plays a clip. */
export interface Output {
  readonly node: AudioNode;
  onreport: (report: Report) => void;
  /** @param transfer  memory that is handed over and not copied */
  send(order: Order, transfer?: Transferable[]): void;
}

async function openWorklet(context: AudioContext, samples: number): Promise<Output> {
  await context.audioWorklet.addModule('worklet.js');
  const node = new AudioWorkletNode(context, 'playback', {
    numberOfInputs: 0, outputChannelCount: [2], processorOptions: { samples },
  });
  const output: Output = {
    node,
    onreport: () => {},
    send: (order, transfer = []) => node.port.postMessage(order, transfer),
  };
  node.port.onmessage = ({ data }: MessageEvent<Report>) => output.onreport(data);
  return output;
}

function openScript(context: AudioContext, samples: number): Output {
  const playback = new Playback(samples, context.sampleRate, (report) => output.onreport(report));
  const node = context.createScriptProcessor(SCRIPT_SAMPLES, 0, 2);
  const output: Output = { node, onreport: () => {}, send: (order) => playback.obey(order) };
  node.onaudioprocess = ({ outputBuffer }) =>
    playback.fill(outputBuffer.getChannelData(0), outputBuffer.getChannelData(1));
  return output;
}

/**
 * Connects the output of a clip with so many samples to the context's destination. Browsers have worklets only on pages
 * of this computer or by HTTPS: with `--host`, the page's main thread supplies the sound.
 */
export async function openOutput(context: AudioContext, samples: number): Promise<Output> {
  const output = await (context.audioWorklet ? openWorklet(context, samples) : openScript(context, samples));
  output.node.connect(context.destination);
  return output;
}
