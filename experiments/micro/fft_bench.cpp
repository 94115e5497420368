// The numbers of docs/adr/0002-fft.md: the project's transform against FFmpeg's av_tx, and the
// delay estimator for which it was written. experiments/peers/peer_gcc_phat.py is the same
// estimator in NumPy.
#include <cmath>
#include <complex>
#include <vector>

#include <benchmark/benchmark.h>

extern "C" {
#include <libavutil/mem.h>
#include <libavutil/tx.h>
}

#include <earpoint/audio/fft.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/core/random.h>

namespace {

std::vector<double> noise(int samples) {
  earpoint::RandomStream random(1);
  std::vector<double> signal(samples);
  for (double& x : signal) x = random.uniform(-1.0, 1.0);
  return signal;
}

template <typename T>
void real_fft(benchmark::State& state) {
  const auto size = static_cast<int>(state.range(0));
  const std::vector<double> signal = noise(size);
  const std::vector<T> input(signal.begin(), signal.end());
  earpoint::RealFft<T> fft(size);
  std::vector<std::complex<T>> spectrum(fft.bins());
  for (auto _ : state) {
    fft.forward(input, spectrum);
    benchmark::DoNotOptimize(spectrum.data());
  }
}

template <typename T, AVTXType kType>
void av_tx_real(benchmark::State& state) {
  const auto size = static_cast<int>(state.range(0));
  AVTXContext* context = nullptr;
  av_tx_fn transform = nullptr;
  const T scale = 1;
  if (av_tx_init(&context, &transform, kType, 0, size, &scale, 0) < 0) {
    state.SkipWithError("av_tx refuses this size");
    return;
  }
  const std::size_t bytes = (static_cast<std::size_t>(size) + 64) * sizeof(T);
  auto* input = static_cast<T*>(av_mallocz(bytes));
  auto* output = static_cast<T*>(av_mallocz(2 * bytes));
  const std::vector<double> signal = noise(size);
  for (auto _ : state) {
    // A transform may overwrite its input.
    for (int n = 0; n < size; ++n) input[n] = static_cast<T>(signal[n]);
    transform(context, output, input, sizeof(T));
    benchmark::DoNotOptimize(output);
  }
  av_free(input);
  av_free(output);
  av_tx_uninit(&context);
}

/// Both ears of a second at 16 kHz, as in the evaluation of one clip.
void gcc_phat_of_a_clip(benchmark::State& state) {
  constexpr int kSamples = 16000;
  const std::vector<double> source = noise(kSamples + 100);
  const std::vector<float> early(source.begin() + 40, source.begin() + 40 + kSamples);
  const std::vector<float> late(source.begin(), source.begin() + kSamples);
  earpoint::GccPhat estimator(kSamples, kSamples);
  for (auto _ : state) {
    double sum = 0.0;
    for (int ear = 0; ear < 2; ++ear) sum += estimator.delay_samples(late, early);
    benchmark::DoNotOptimize(sum);
  }
}

BENCHMARK(real_fft<double>)->Arg(512)->Arg(12000)->Arg(32000)->Arg(32768)->Arg(131072);
BENCHMARK(av_tx_real<double, AV_TX_DOUBLE_RDFT>)->Arg(512)->Arg(12000)->Arg(32768)->Arg(131072);
BENCHMARK(real_fft<float>)->Arg(512)->Arg(32768);
BENCHMARK(av_tx_real<float, AV_TX_FLOAT_RDFT>)->Arg(512)->Arg(32768);
BENCHMARK(gcc_phat_of_a_clip)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
