import { colour } from './map';

const WAVE_SAMPLES = 2048;
const HEIGHT = 160; // of both spectrograms together, pixels
const WIDTH = 600;
const STEP = 2; // columns per drawing
const FLOOR_DB = -110;
const RANGE_DB = 80;

/** From black through violet and orange to white, by level. */
const SHADES = Uint8ClampedArray.from({ length: 1024 }, (_, i) => {
  const share = (i >> 2) / 255;
  return [255 * Math.min(1, 1.6 * share), 255 * Math.max(0, 1.8 * share - 0.8),
    255 * Math.max(0.12, share < 0.5 ? 0.9 * share : 1.1 - 1.2 * share, 4 * share - 3), 255][i & 3];
});

/** Draws waveforms and spectrograms of both ears while sound plays. */
export class Scope {
  private readonly ears: AnalyserNode[];
  private readonly samples = new Float32Array(WAVE_SAMPLES);
  private readonly levels;
  private readonly bins: number[]; // of each row of a spectrogram; low frequencies get more rows

  constructor(
    source: AudioNode, private readonly waves: HTMLCanvasElement, private readonly spectrogram: HTMLCanvasElement,
  ) {
    const splitter = new ChannelSplitterNode(source.context, { numberOfOutputs: 2 });
    source.connect(splitter);
    this.ears = [0, 1].map((ear) => {
      const analyser = new AnalyserNode(source.context, { fftSize: WAVE_SAMPLES, smoothingTimeConstant: 0.3 });
      splitter.connect(analyser, ear);
      return analyser;
    });
    this.levels = new Float32Array(this.ears[0].frequencyBinCount);
    const highest = (8000 / (source.context.sampleRate / 2)) * this.levels.length;
    const half = HEIGHT / 2;
    this.bins = Array.from({ length: half }, (_, y) => Math.floor(((half - 1 - y) / half) ** 2 * highest));
    spectrogram.width = WIDTH;
    spectrogram.height = HEIGHT;
  }

  /** The loudest sample of each ear just now. */
  peaks(): number[] {
    return this.ears.map((ear) => {
      ear.getFloatTimeDomainData(this.samples);
      return this.samples.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    });
  }

  draw(): void {
    this.drawWaves();
    this.drawSpectra();
  }

  private drawWaves(): void {
    const { waves, samples } = this;
    waves.width = waves.clientWidth;
    waves.height = waves.clientHeight;
    const pen = waves.getContext('2d')!;
    this.ears.forEach((ear, i) => {
      ear.getFloatTimeDomainData(samples);
      const middle = (waves.height * (2 * i + 1)) / 4;
      pen.strokeStyle = colour(i === 0 ? '--left' : '--right');
      pen.beginPath();
      for (let x = 0; x < waves.width; ++x) {
        const sample = samples[Math.floor((x / waves.width) * samples.length)];
        pen.lineTo(x, middle - sample * waves.height * 0.24 * 2);
      }
      pen.stroke();
      pen.fillStyle = colour('--faint');
      pen.fillText(i === 0 ? 'left ear' : 'right ear', 4, middle - waves.height / 4 + 12);
    });
  }

  private drawSpectra(): void {
    const pen = this.spectrogram.getContext('2d')!;
    pen.drawImage(this.spectrogram, -STEP, 0);
    const column = pen.createImageData(1, HEIGHT);
    this.ears.forEach((ear, i) => {
      ear.getFloatFrequencyData(this.levels);
      this.bins.forEach((bin, y) => {
        const share = Math.max(0, Math.min(1, (this.levels[bin] - FLOOR_DB) / RANGE_DB));
        const shade = 4 * Math.round(255 * share);
        column.data.set(SHADES.subarray(shade, shade + 4), 4 * (i * this.bins.length + y));
      });
    });
    for (let x = 1; x <= STEP; ++x) pen.putImageData(column, WIDTH - x, 0);
  }
}
