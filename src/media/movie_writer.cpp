#include <earpoint/media/movie_writer.h>

#include "encoder.h"
#include "output_container.h"
#include "picture_writer.h"

#include <optional>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using ffmpeg::OutputContainer;

/// Pictures that the caller hands over one by one.
class GivenPictures : public ffmpeg::PictureWriter {
 public:
  GivenPictures(OutputContainer& output, int width, int height, AVRational frame_rate)
      : output_(output),
        encoder_(output.path().string(), width, height, frame_rate, av_inv_q(frame_rate)),
        stream_(output.add_stream(encoder_.codec())),
        width_(width),
        height_(height) {}

  void write(const Image& image) {
    EARPOINT_CHECK(image.width() == width_ && image.height() == height_);
    encoder_.encode(image, count_++, [this](AVPacket& packet) { put(packet); });
  }
  void write_until(double /*time_s*/) override {}
  void finish() override {
    EARPOINT_CHECK(count_ > 0);
    encoder_.flush([this](AVPacket& packet) { put(packet); });
  }

 private:
  void put(AVPacket& packet) { output_.write(packet, stream_, encoder_.codec().time_base); }

  OutputContainer& output_;
  ffmpeg::PictureEncoder encoder_;
  AVStream& stream_;
  int width_;
  int height_;
  std::int64_t count_ = 0;
};

}  // namespace

struct MovieWriter::State {
  State(const fs::path& path, int sample_rate_hz)
      : output(path), sound(path.string(), sample_rate_hz) {}

  void begin(std::unique_ptr<ffmpeg::PictureWriter> source) {
    pictures = std::move(source);
    sound_stream = &output.add_stream(sound.codec());  // after the picture, as is the custom
    output.begin();
  }

  /// Keeps picture and sound close together in the file.
  void put_sound(AVPacket& packet) {
    const AVRational tick = sound.codec().time_base;
    pictures->write_until(static_cast<double>(packet.pts) * av_q2d(tick));
    output.write(packet, *sound_stream, tick);
  }

  /// Runs one step; after an error the movie is lost and takes no more.
  template <typename Step>
  void step(const Step& run) {
    EARPOINT_CHECK(is_open);
    is_open = false;
    run();
    is_open = true;
  }

  OutputContainer output;
  ffmpeg::SoundEncoder sound;
  AVStream* sound_stream = nullptr;
  std::unique_ptr<ffmpeg::PictureWriter> pictures;
  GivenPictures* given = nullptr;  // the same, if the caller hands them over
  bool is_open = true;
};

MovieWriter::MovieWriter(const fs::path& path, const fs::path& source, int sample_rate_hz)
    : state_(std::make_unique<State>(path, sample_rate_hz)) {
  state_->begin(ffmpeg::picture_of_movie(source, state_->output));
}

MovieWriter::MovieWriter(const fs::path& path, int width, int height, double frame_rate_hz,
                         int sample_rate_hz) {
  EARPOINT_CHECK(width > 0 && height > 0 && frame_rate_hz > 0.0);
  state_ = std::make_unique<State>(path, sample_rate_hz);
  constexpr int kLargestDenominator = 1001;  // holds 30000/1001
  auto pictures = std::make_unique<GivenPictures>(state_->output, width, height,
                                                  av_d2q(frame_rate_hz, kLargestDenominator * 60));
  state_->given = pictures.get();
  state_->begin(std::move(pictures));
}

MovieWriter::~MovieWriter() = default;
MovieWriter::MovieWriter(MovieWriter&&) noexcept = default;
MovieWriter& MovieWriter::operator=(MovieWriter&&) noexcept = default;

void MovieWriter::write_sound(const Waveform& block) {
  state_->step(
      [&] { state_->sound.encode(block, [&](AVPacket& packet) { state_->put_sound(packet); }); });
}

void MovieWriter::write_picture(const Image& image) {
  EARPOINT_CHECK(state_->given != nullptr);
  state_->step([&] { state_->given->write(image); });
}

void MovieWriter::close() {
  state_->step([&] {
    state_->sound.flush([&](AVPacket& packet) { state_->put_sound(packet); });
    EARPOINT_CHECK(state_->sound.samples() > 0);
    state_->pictures->finish();
    state_->output.finish();
  });
  state_->is_open = false;
}

}  // namespace earpoint
