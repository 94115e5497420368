#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class SoundFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("sound_file_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] auto entries() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_;
};

Waveform noise(int channels, std::ptrdiff_t samples, int rate_hz) {
  RandomStream random(7);
  Waveform wave(channels, samples, rate_hz);
  for (float& x : wave.planar()) x = static_cast<float>(random.uniform(-0.9, 0.9));
  return wave;
}

/// Without the flush to disk of write_file(), which hundreds of small files would wait for.
void put(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

double largest_difference(const Waveform& a, const Waveform& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.planar().size(); ++i) {
    largest = std::max(largest, std::abs(double{a.planar()[i]} - b.planar()[i]));
  }
  return largest;
}

std::string message_of(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(SoundFile, LosslessFormatsGiveBackTheirSamples) {
  const Waveform wave = noise(2, 100000, 44100);
  for (const char* extension : {".wav", ".w64", ".flac", ".WAV"}) {
    for (const auto& [format, step] : {std::pair{SampleFormat::pcm16, 1.0 / 32768},
                                       {SampleFormat::pcm24, 1.0 / 8388608},
                                       {SampleFormat::float32, 0.0}}) {
      if (extension == std::string(".flac") && format == SampleFormat::float32) continue;
      const fs::path path = folder_ / (std::string("x") + extension);
      write_sound(path, wave, format);
      const SoundInfo info = probe_sound(path);
      EXPECT_EQ(info.channels, 2);
      EXPECT_EQ(info.sample_rate_hz, 44100);
      EXPECT_EQ(info.frames, 100000);
      // Rounding to the nearest step is at most half a step off.
      EXPECT_LE(largest_difference(wave, read_sound(path)), 0.5001 * step) << path;
    }
  }
}

TEST_F(SoundFile, OggKeepsWhatOneHears) {
  Waveform wave(2, 32000, 16000);
  for (int i = 0; i < 32000; ++i) {
    wave.channel(0)[i] = 0.5F * std::sin(0.1F * static_cast<float>(i));
    wave.channel(1)[i] = 0.25F * std::sin(0.05F * static_cast<float>(i));
  }
  write_sound(folder_ / "x.ogg", wave);
  const Waveform back = read_sound(folder_ / "x.ogg");
  ASSERT_EQ(back.samples(), wave.samples());
  ASSERT_EQ(back.channels(), 2);
  // Vorbis is lossy: 2 % of full scale for two tones.
  EXPECT_LT(largest_difference(wave, back), 0.02);
}

TEST_F(SoundFile, Mp3KeepsWhatOneHears) {
  Waveform wave(2, 32000, 16000);
  for (int i = 0; i < 32000; ++i) {
    wave.channel(0)[i] = 0.5F * std::sin(0.1F * static_cast<float>(i));
    wave.channel(1)[i] = 0.25F * std::sin(0.05F * static_cast<float>(i));
  }
  write_sound(folder_ / "x.mp3", wave);
  const Waveform back = read_sound(folder_ / "x.mp3");
  ASSERT_EQ(back.samples(), wave.samples());  // the header states the encoder's delay and padding
  // MP3 is lossy: 2 % of full scale for two tones, their abrupt beginning and end left out.
  double largest = 0.0;
  for (int c = 0; c < 2; ++c) {
    for (int i = 2000; i < 30000; ++i) {
      largest = std::max(largest, std::abs(double{wave.channel(c)[i]} - back.channel(c)[i]));
    }
  }
  EXPECT_LT(largest, 0.02);
}

TEST_F(SoundFile, BlocksReadAndWrittenAreTheWhole) {
  const Waveform wave = noise(2, 10000, 16000);
  SoundWriter writer(folder_ / "x.wav", 2, 16000, SampleFormat::float32);
  for (std::ptrdiff_t start = 0; start < 10000; start += 2500) {
    Waveform block(2, 2500, 16000);
    for (int c = 0; c < 2; ++c) {
      std::ranges::copy(wave.channel(c).subspan(start, 2500), block.channel(c).begin());
    }
    writer.write(block);
  }
  EXPECT_FALSE(fs::exists(folder_ / "x.wav"));
  writer.close();

  SoundReader reader(folder_ / "x.wav");
  std::ptrdiff_t position = 0;
  for (;;) {
    const Waveform block = reader.read(3000);
    if (block.samples() == 0) break;
    EXPECT_EQ(block.samples(), std::min<std::ptrdiff_t>(3000, 10000 - position));
    for (int c = 0; c < 2; ++c) {
      for (std::ptrdiff_t i = 0; i < block.samples(); ++i) {
        ASSERT_EQ(block.channel(c)[i], wave.channel(c)[position + i]);
      }
    }
    position += block.samples();
  }
  EXPECT_EQ(position, 10000);
  EXPECT_EQ(reader.read(1).samples(), 0);
}

TEST_F(SoundFile, MoreThanTwoChannelsAreRead) {
  const Waveform wave = noise(9, 1000, 48000);
  write_sound(folder_ / "x.wav", wave, SampleFormat::float32);
  EXPECT_EQ(probe_sound(folder_ / "x.wav").channels, 9);
  EXPECT_EQ(largest_difference(wave, read_sound(folder_ / "x.wav")), 0.0);
}

TEST_F(SoundFile, SixteenBitsSurviveAnyNumberOfRoundTrips) {
  Waveform wave(1, 65536, 16000);
  for (int i = 0; i < 65536; ++i) {
    wave.channel(0)[i] = static_cast<float>(i - 32768) / 32768.0F;
  }
  for (const char* name : {"x.wav", "x.flac"}) {
    write_sound(folder_ / name, wave, SampleFormat::pcm16);
    EXPECT_EQ(largest_difference(wave, read_sound(folder_ / name)), 0.0);
  }
}

TEST_F(SoundFile, IntegerFormatsClampAndCountIt) {
  Waveform wave(1, 4, 16000);
  std::ranges::copy(std::vector<float>{2.0F, -1.5F, 1.0F, 0.5F}, wave.planar().begin());
  SoundWriter writer(folder_ / "x.wav", 1, 16000, SampleFormat::pcm16);
  writer.write(wave);
  EXPECT_EQ(writer.clamped_samples(), 2);
  writer.close();
  const Waveform back = read_sound(folder_ / "x.wav");
  EXPECT_EQ(back.channel(0)[0], 32767.0F / 32768.0F);
  EXPECT_EQ(back.channel(0)[1], -1.0F);
  EXPECT_EQ(back.channel(0)[2], 32767.0F / 32768.0F);
  EXPECT_EQ(back.channel(0)[3], 0.5F);

  write_sound(folder_ / "y.wav", wave, SampleFormat::float32);
  EXPECT_EQ(read_sound(folder_ / "y.wav").channel(0)[0], 2.0F);
}

TEST_F(SoundFile, EqualSamplesGiveEqualBytes) {
  const Waveform wave = noise(2, 5000, 16000);
  for (const auto& [name, format] : {std::pair{"x.wav", SampleFormat::float32},
                                     {"x.w64", SampleFormat::float32},
                                     {"x.wav", SampleFormat::pcm24},
                                     {"x.flac", SampleFormat::pcm16}}) {
    write_sound(folder_ / name, wave, format);
    const std::string first = read_text_file(folder_ / name);
    write_sound(folder_ / name, wave, format);
    EXPECT_TRUE(read_text_file(folder_ / name) == first) << name;
    // A time stamp would differ only a second later.
    EXPECT_EQ(first.find("PEAK"), std::string::npos) << name;
  }
}

TEST_F(SoundFile, BadFilesAreNamedInOneLine) {
  write_file(folder_ / "empty.wav", "");
  write_file(folder_ / "text.wav", "this is not a sound\nat all");
  write_sound(folder_ / "nothing.wav", Waveform(2, 0, 16000));
  for (const auto& [name, problem] : {std::pair{"missing.wav", "no such file"},
                                      {".", "is not a file"},
                                      {"empty.wav", "is empty (0 bytes)"},
                                      {"text.wav", "is not a readable sound file"},
                                      {"nothing.wav", "holds no samples"}}) {
    const std::string message = message_of([&, name = name] { (void)read_sound(folder_ / name); });
    EXPECT_NE(message.find(problem), std::string::npos) << message;
    EXPECT_EQ(message.find((folder_ / name).string()), 0U) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(probe_sound(folder_ / "nothing.wav").frames, 0);
}

TEST_F(SoundFile, TruncatedFilesAreRefusedWhereverTheyEnd) {
  const Waveform wave = noise(2, 20000, 16000);
  for (const auto& [name, format] : {std::pair{"x.wav", SampleFormat::pcm16},
                                     {"x.wav", SampleFormat::float32},
                                     {"x.w64", SampleFormat::pcm24},
                                     {"x.flac", SampleFormat::pcm16},
                                     {"x.ogg", SampleFormat::pcm16}}) {
    write_sound(folder_ / name, wave, format);
    const std::string whole = read_text_file(folder_ / name);
    for (const double part : {0.0001, 0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.9999}) {
      const auto size = static_cast<std::size_t>(part * static_cast<double>(whole.size()));
      // Some programs count the few bytes of a header as samples: such a file is not truncated.
      if (std::string_view(name) == "x.wav" && whole.size() - size <= 64) continue;
      put(folder_ / name, std::string_view(whole).substr(0, size));
      const std::string message =
          message_of([&, name = name] { (void)read_sound(folder_ / name); });
      EXPECT_NE(message, "no error") << name << " cut to " << size << " of " << whole.size();
    }
  }
}

TEST_F(SoundFile, LengthsThatRecordersLeaveOpenAreRead) {
  const Waveform wave = noise(2, 5000, 16000);
  write_sound(folder_ / "x.wav", wave, SampleFormat::float32);
  std::string bytes = read_text_file(folder_ / "x.wav");
  const std::size_t data = bytes.find("data");
  ASSERT_NE(data, std::string::npos);
  const auto samples = static_cast<std::uint32_t>(bytes.size() - data - 8);
  for (const std::uint32_t open : {0xFFFFFFFFU, 0x7FFFF000U, 0U, samples + 16}) {
    std::memcpy(bytes.data() + data + 4, &open, 4);
    std::memcpy(bytes.data() + 4, &open, 4);
    put(folder_ / "x.wav", bytes);
    EXPECT_EQ(largest_difference(wave, read_sound(folder_ / "x.wav")), 0.0) << open;
  }
}

TEST_F(SoundFile, AWavFileThatIsToHoldMoreThanFourGigabytesIsRf64) {
  const Waveform wave = noise(2, 5000, 16000);
  const fs::path path = folder_ / "x.wav";
  for (const std::int64_t expected : {std::int64_t{0}, std::int64_t{500'000'000}}) {
    SoundWriter writer(path, 2, 16000, SampleFormat::float32, expected);
    writer.write(wave);
    writer.close();
    EXPECT_EQ(read_text_file(path).substr(0, 4), "RIFF") << expected;
  }
  SoundWriter writer(path, 2, 16000, SampleFormat::float32, 600'000'000);  // of 8 bytes
  writer.write(wave);
  writer.close();
  EXPECT_EQ(read_text_file(path).substr(0, 4), "RF64");
  EXPECT_EQ(largest_difference(wave, read_sound(path)), 0.0);
}

TEST_F(SoundFile, Rf64BeyondFourGigabytesIsReadWithItsWholeLength) {
  const Waveform wave = noise(2, 5000, 16000);
  const fs::path path = folder_ / "x.wav";
  SoundWriter writer(path, 2, 16000, SampleFormat::float32, 600'000'000);
  writer.write(wave);
  writer.close();
  // The lengths of the form and of its samples (EBU Tech 3306), and a hole for what comes later.
  std::string bytes = read_text_file(path);
  ASSERT_EQ(bytes.substr(12, 4), "ds64");
  const std::size_t data = bytes.find("data") + 8;
  const std::uint64_t samples = 600'000'000;
  const std::uint64_t length = samples * 8;
  const std::uint64_t whole = data + length - 8;
  std::memcpy(bytes.data() + 20, &whole, 8);
  std::memcpy(bytes.data() + 28, &length, 8);
  put(path, bytes);
  fs::resize_file(path, data + length);
  SoundReader reader(path);
  EXPECT_EQ(reader.info().frames, static_cast<std::int64_t>(samples));
  EXPECT_EQ(largest_difference(wave, reader.read(5000)), 0.0);
}

TEST_F(SoundFile, CorruptFlacIsFoundByItsChecksums) {
  write_sound(folder_ / "x.flac", noise(1, 50000, 16000), SampleFormat::pcm16);
  std::string bytes = read_text_file(folder_ / "x.flac");
  RandomStream random(11);
  for (int trial = 0; trial < 20; ++trial) {
    std::string broken = bytes;
    for (int i = 0; i < 3; ++i) {
      broken[1000 + random.index(bytes.size() - 1000)] ^= static_cast<char>(1 + random.index(255));
    }
    put(folder_ / "y.flac", broken);
    EXPECT_NE(message_of([&] { (void)read_sound(folder_ / "y.flac"); }), "no error");
  }
}

TEST_F(SoundFile, AnyBytesGiveSamplesOrOneError) {
  for (const char* name : {"x.wav", "x.w64", "x.flac", "x.ogg"}) {
    write_sound(folder_ / name, noise(2, 3000, 16000), SampleFormat::pcm16);
    const std::string bytes = read_text_file(folder_ / name);
    RandomStream random(12);
    for (int trial = 0; trial < 200; ++trial) {
      std::string broken = bytes;
      // The first bytes describe the rest of the file.
      for (int i = 0; i < 4; ++i) {
        broken[random.index(std::min<std::size_t>(bytes.size(), 200))] ^=
            static_cast<char>(1 + random.index(255));
      }
      put(folder_ / name, broken);
      try {
        const Waveform wave = read_sound(folder_ / name);
        for (const float x : wave.planar()) ASSERT_TRUE(std::isfinite(x));
      } catch (const InputError&) {
      }
    }
  }
}

TEST_F(SoundFile, SamplesThatAreNoNumbersAreLocated) {
  Waveform wave = noise(2, 5000, 16000);
  write_sound(folder_ / "x.wav", wave, SampleFormat::float32);
  std::string bytes = read_text_file(folder_ / "x.wav");
  const std::size_t samples = bytes.find("data") + 8;
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    std::string broken = bytes;
    std::memcpy(broken.data() + samples + 4 * (2 * 1234 + 1), &bad, 4);
    put(folder_ / "y.wav", broken);
    const std::string message = message_of([&] { (void)read_sound(folder_ / "y.wav"); });
    EXPECT_NE(message.find("sample 1234 of channel 1 is not a finite number"), std::string::npos)
        << message;
  }
  wave.channel(1)[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(write_sound(folder_ / "z.wav", wave), std::logic_error);
  EXPECT_FALSE(fs::exists(folder_ / "z.wav"));
}

TEST_F(SoundFile, FormatsThatCannotBeWrittenAreRefusedAtOnce) {
  const Waveform wave = noise(2, 10, 16000);
  EXPECT_NE(message_of([&] { write_sound(folder_ / "x.wma", wave); }).find("'.wma'"),
            std::string::npos);
  EXPECT_NE(message_of([&] { write_sound(folder_ / "x", wave); }).find("use the extension"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              write_sound(folder_ / "x.flac", wave, SampleFormat::float32);
            }).find("16 or 24 bits"),
            std::string::npos);
  EXPECT_NE(
      message_of([&] { write_sound(folder_ / "x.flac", noise(9, 10, 16000)); }).find("9 channels"),
      std::string::npos);
  EXPECT_NE(message_of([&] { write_sound(folder_ / "no" / "x.wav", wave); }).find("folder"),
            std::string::npos);
  EXPECT_EQ(entries(), 0);
}

TEST_F(SoundFile, WriterThatIsNotClosedLeavesNothing) {
  write_file(folder_ / "x.wav", "old");
  {
    SoundWriter writer(folder_ / "x.wav", 1, 16000);
    writer.write(noise(1, 100, 16000));
  }
  EXPECT_EQ(entries(), 1);
  EXPECT_EQ(read_text_file(folder_ / "x.wav"), "old");
}

/// Writes beyond `bytes` fail, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(SoundFile, FullDiskIsOneErrorAndLeavesNothing) {
  const Waveform wave = noise(2, 100000, 16000);
  for (const char* name : {"x.wav", "x.w64", "x.flac", "x.ogg"}) {
    for (const rlim_t bytes : {1UL, 100UL, 10000UL, 40000UL}) {
      const FileSizeLimit limit(bytes);
      const std::string message = message_of([&] { write_sound(folder_ / name, wave); });
      EXPECT_NE(message.find("cannot be written ("), std::string::npos) << name << ": " << message;
    }
    EXPECT_EQ(entries(), 0);
  }
}

}  // namespace
}  // namespace earpoint
