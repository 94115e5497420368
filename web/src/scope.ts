function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Waveforms and spectrograms of both ears, while they sound. */
export class Scope {
  private readonly ears: AnalyserNode[];

  constructor(
    source: AudioNode, private readonly waves: HTMLCanvasElement, private readonly spectrogram: HTMLCanvasElement,
  ) {
    const splitter = new ChannelSplitterNode(source.context, { numberOfOutputs: 2 });
    source.connect(splitter);
    this.ears = [0, 1].map((ear) => {
      const analyser = new AnalyserNode(source.context, { fftSize: 2048, smoothingTimeConstant: 0.3 });
      splitter.connect(analyser, ear);
      return analyser;
    });
    spectrogram.width = 600;
    spectrogram.height = 160;
  }

  /** The loudest sample of each ear just now. */
  peaks(): number[] {
    const samples = new Float32Array(2048);
    return this.ears.map((ear) => {
      ear.getFloatTimeDomainData(samples);
      return samples.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    });
  }

  draw(): void {
    this.drawWaves();
    this.drawSpectra();
  }

  private drawWaves(): void {
    const { waves } = this;
    waves.width = waves.clientWidth;
    waves.height = waves.clientHeight;
    const pen = waves.getContext('2d')!;
    const samples = new Float32Array(2048);
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
    const { spectrogram } = this;
    const pen = spectrogram.getContext('2d')!;
    pen.drawImage(spectrogram, -1, 0);
    const bins = new Uint8Array(this.ears[0].frequencyBinCount);
    const half = spectrogram.height / 2;
    this.ears.forEach((ear, i) => {
      ear.getByteFrequencyData(bins);
      for (let y = 0; y < half; ++y) {
        // Low frequencies get more room.
        const level = bins[Math.floor(((half - 1 - y) / half) ** 2 * bins.length * 0.5)];
        pen.fillStyle = `hsl(${260 - level} 80% ${8 + level / 5}%)`;
        pen.fillRect(spectrogram.width - 1, i * half + y, 1, 1);
      }
    });
  }
}
