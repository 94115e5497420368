#include <earpoint/render_files/open_sound_sink.h>

#include <algorithm>
#include <cctype>
#include <string>

#include <earpoint/audio/sound_file.h>
#include <earpoint/error.h>
#include <earpoint/media/movie_writer.h>

namespace earpoint {
namespace {

class SoundFileSink : public SoundSink {
 public:
  SoundFileSink(const std::filesystem::path& output, int channels, int sample_rate_hz,
                SampleFormat format, std::ptrdiff_t samples)
      : writer_(output, channels, sample_rate_hz, format, samples),
        channels_(channels),
        sample_rate_hz_(sample_rate_hz) {}
  void write(const Waveform& block) override {
    if (channels_ == block.channels()) {
      writer_.write(block);
      return;
    }
    Waveform first(1, block.samples(), block.sample_rate_hz());
    std::ranges::copy(block.channel(0), first.channel(0).begin());
    writer_.write(first);
  }
  void commit() override { writer_.close(); }
  [[nodiscard]] int sample_rate_hz() const override { return sample_rate_hz_; }

 private:
  SoundWriter writer_;
  int channels_;
  int sample_rate_hz_;
};

class MovieSink : public SoundSink {
 public:
  MovieSink(const std::filesystem::path& output, int sample_rate_hz,
            const std::filesystem::path& movie)
      : writer_(output, movie, sample_rate_hz), sample_rate_hz_(sample_rate_hz) {}
  void write(const Waveform& block) override { writer_.write_sound(block); }
  void commit() override { writer_.close(); }
  [[nodiscard]] int sample_rate_hz() const override { return sample_rate_hz_; }

 private:
  MovieWriter writer_;
  int sample_rate_hz_;
};

}  // namespace

std::unique_ptr<SoundSink> open_sound_sink(const std::filesystem::path& output, int sample_rate_hz,
                                           const std::filesystem::path& movie,
                                           std::ptrdiff_t samples, int channels) {
  std::string extension = output.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".mp4" || extension == ".m4v" || extension == ".mov" || extension == ".mkv") {
    if (movie.empty()) {
      throw InputError(output.string(), "the source has no moving picture for a movie",
                       "write .wav or .flac");
    }
    return std::make_unique<MovieSink>(output, sample_rate_hz, movie);
  }
  if (extension == ".wav" || extension == ".w64" || output == "-") {
    // An earpoint near the mouth can exceed full scale; float keeps that.
    return std::make_unique<SoundFileSink>(output, channels, sample_rate_hz, SampleFormat::float32,
                                           samples);
  }
  if (extension == ".flac" || extension == ".ogg" || extension == ".mp3") {
    return std::make_unique<SoundFileSink>(output, channels, sample_rate_hz, SampleFormat::pcm24,
                                           samples);
  }
  throw InputError(output.string(), "cannot write '" + extension + "' files",
                   "use .wav, .flac, .ogg, .mp3, .w64, .mp4, .mov or .mkv");
}

}  // namespace earpoint
