#include "test_media.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/media/media.h>

namespace earpoint {
namespace {

class AudioReaderTest : public MediaTest {
 protected:
  /// Clicks of four samples at 0.25 s (left) and 0.75 s (right), 1 s in all.
  static std::string clicks(int rate) {
    return fmt::format(
        "-f lavfi -i \"aevalsrc='if(between(n,{0},{0}+3),0.5,0)|if(between(n,3*{0},3*{0}+3),-0.5,0)"
        "':s={1}:d=1:c=stereo\"",
        rate / 4, rate);
  }
};

struct Ears {
  std::vector<float> left;
  std::vector<float> right;
};

Ears read_all(AudioReader& reader, std::ptrdiff_t block = 777) {
  Ears ears;
  for (;;) {
    const Waveform waveform = reader.read(block);
    EXPECT_EQ(waveform.channels(), 2);
    ears.left.insert(ears.left.end(), waveform.channel(0).begin(), waveform.channel(0).end());
    ears.right.insert(ears.right.end(), waveform.channel(1).begin(), waveform.channel(1).end());
    if (waveform.samples() < block) break;
  }
  EXPECT_EQ(reader.read(block).samples(), 0) << "nothing after the end";
  return ears;
}

/// The centre of a channel's energy: where a click is, whatever form the codec has given it.
double centre_of(const std::vector<float>& channel) {
  double energy = 0.0;
  double moment = 0.0;
  for (std::size_t i = 0; i < channel.size(); ++i) {
    const double e = double{channel[i]} * channel[i];
    energy += e;
    moment += e * static_cast<double>(i);
  }
  return moment / energy;
}

TEST_F(AudioReaderTest, LosslessSoundComesBackBitForBit) {
  for (const char* name : {"a.wav", "a.flac", "a.mov", "a.mkv", "a.w64", "a.aiff"}) {
    const bool is_flac = std::strcmp(name, "a.flac") == 0;
    run_ffmpeg(fmt::format("{} -c:a {} {}", clicks(44100),
                           is_flac                            ? "flac"
                           : std::strcmp(name, "a.aiff") == 0 ? "pcm_s16be"
                                                              : "pcm_s16le",
                           name));
    AudioReader reader(file(name));
    EXPECT_EQ(reader.sample_rate_hz(), 44100);
    const Ears ears = read_all(reader);
    ASSERT_EQ(ears.left.size(), 44100U) << name;
    for (int i = 0; i < 44100; ++i) {
      const bool in_left = i >= 11025 && i < 11029;
      const bool in_right = i >= 33075 && i < 33079;
      ASSERT_EQ(ears.left[static_cast<std::size_t>(i)], in_left ? 0.5F : 0.0F) << name << i;
      ASSERT_EQ(ears.right[static_cast<std::size_t>(i)], in_right ? -0.5F : 0.0F) << name << i;
    }
  }
}

TEST_F(AudioReaderTest, AWaveFileFromAPipeHasNoLengthAndNoFault) {
  run_ffmpeg(fmt::format("{} -f wav pipe: > a.wav", clicks(44100)));
  AudioReader reader(file("a.wav"));
  EXPECT_EQ(read_all(reader).left.size(), 44100U);
}

TEST_F(AudioReaderTest, WaveFilesGoToTheirTrueEndWhateverTheirHeaderSays) {
  run_ffmpeg(fmt::format("{} -bitexact a.wav", clicks(16000)));
  std::string bytes = read_text_file(file("a.wav"));
  const std::size_t data = bytes.find("data");
  const auto samples = static_cast<std::uint32_t>(bytes.size() - data - 8);
  for (const std::uint32_t length : {0U, 0x7FFFF000U, 0xFFFFFFFFU, samples + 16}) {
    std::memcpy(bytes.data() + 4, &length, 4);
    std::memcpy(bytes.data() + data + 4, &length, 4);
    write_file(file("a.wav"), bytes);
    AudioReader reader(file("a.wav"));
    EXPECT_EQ(read_all(reader).left.size(), 16000U) << length;
  }
  write_file(file("a.wav"), bytes.substr(0, bytes.size() / 2));
  AudioReader cut(file("a.wav"));
  EXPECT_TRUE(mentions(input_error([&] { read_all(cut); }), "ends too early"));
}

TEST_F(AudioReaderTest, JumpsOfATransportStreamsClockAreClosedAndTold) {
  // Back to where the first began; back to zero, which FFmpeg takes for a wrapped clock; and
  // forward.
  const std::string movie =
      fmt::format("-f lavfi -i testsrc2=s=64x48:r=25:d=1 {} -c:a mp2 -b:a 192k", clicks(48000));
  for (const auto& [first_s, second_s] : {std::pair{0, 0}, {500, 0}, {0, 500}}) {
    run_ffmpeg(fmt::format("{} -output_ts_offset {} a.ts", movie, first_s));
    run_ffmpeg(fmt::format("{} -output_ts_offset {} b.ts", movie, second_s));
    write_file(file("c.ts"), read_text_file(file("a.ts")) + read_text_file(file("b.ts")));
    AudioReader reader(file("c.ts"));
    const Ears ears = read_all(reader);
    // MP2 frames of 24 ms: a second of picture is exact, a second of sound is a frame longer.
    EXPECT_NEAR(static_cast<double>(ears.left.size()), 2.0 * 48000, 0.1 * 48000);
    ASSERT_EQ(reader.warnings().size(), 1U) << first_s << " " << second_s;
    EXPECT_TRUE(mentions(reader.warnings()[0], "its clock jumps after")) << reader.warnings()[0];

    // Picture and sound stay in sync: the second part's first frame comes with its first sample.
    FrameReader frames(file("c.ts"));
    EXPECT_NEAR(frames.duration_s(), 2.0, 0.1);
    for (double t = 0.0; t < 3.0; t += 0.5) (void)frames.frame_nearest(t);
    EXPECT_NEAR(frames.frame_time_s(), 1.96, 0.1);
    EXPECT_EQ(frames.frames_decoded(), 50);
  }
}

TEST_F(AudioReaderTest, AGapIsSilenceAndTold) {
  run_ffmpeg(fmt::format("{} -c:a pcm_s16le a.mkv", clicks(16000)));
  run_ffmpeg("-i a.mkv -af \"asetpts=PTS+if(gt(T\\,0.5)\\,3/TB\\,0)\" -c:a pcm_s16le b.mkv");
  AudioReader reader(file("b.mkv"));
  // The gap begins at the first block of ffmpeg that starts later than 0.5 s: up to 0.1 s.
  EXPECT_NEAR(static_cast<double>(read_all(reader).left.size()), 4.0 * 16000, 0.1 * 16000);
  ASSERT_EQ(reader.warnings().size(), 1U);
  EXPECT_TRUE(mentions(reader.warnings()[0], "has no sound from")) << reader.warnings()[0];
}

TEST_F(AudioReaderTest, ATrackThatCannotBeDecodedIsPassedOver) {
  run_ffmpeg(fmt::format("{0} {0} -map 0 -map 1 -c:a aac a.mp4", clicks(48000)));
  std::string bytes = read_text_file(file("a.mp4"));
  for (const auto& [known, unknown] : {std::pair{"mp4a", "apac"}, {"esds", "apad"}}) {
    const std::size_t codec = bytes.find(known);
    ASSERT_NE(codec, std::string::npos);
    bytes.replace(codec, 4, unknown);
  }
  write_file(file("a.mp4"), bytes);
  AudioReader reader(file("a.mp4"));
  EXPECT_EQ(reader.info().index, 1);
  ASSERT_EQ(reader.warnings().size(), 1U);
  EXPECT_TRUE(mentions(reader.warnings()[0], "audio stream 0 cannot be decoded"))
      << reader.warnings()[0];
  EXPECT_TRUE(
      mentions(input_error([&] { AudioReader(file("a.mp4"), std::nullopt, 0); }), "no decoder"));
}

TEST_F(AudioReaderTest, ReadsEverySampleFormat) {
  for (const char* codec :
       {"pcm_u8", "pcm_s16le", "pcm_s24le", "pcm_s32le", "pcm_f32le", "pcm_f64le"}) {
    run_ffmpeg(fmt::format("{} -c:a {} a.wav", clicks(16000), codec));
    AudioReader reader(file("a.wav"));
    const Ears ears = read_all(reader);
    ASSERT_EQ(ears.left.size(), 16000U);
    EXPECT_EQ(ears.left[4000], 0.5F) << codec;
    EXPECT_EQ(ears.right[12000], -0.5F) << codec;
    EXPECT_EQ(ears.left[12000], 0.0F) << codec;
  }
}

TEST_F(AudioReaderTest, EncodersDelayAndFillingAreRemoved) {
  struct Case {
    const char* name;
    const char* codec;
    int rate;
    int samples;
  };
  for (const Case& c :
       {Case{"a.m4a", "aac", 44100, 44100}, Case{"a.mp4", "aac", 16000, 16000},
        Case{"a.mp3", "libmp3lame", 44100,
             44100},  // FFmpeg 5.1 takes 128 samples too many off the end of an Ogg file.
        Case{"a.ogg", "libvorbis", 44100, 44100 - 128}, Case{"b.ogg", "libopus", 48000, 48000},
        Case{"b.mp4", "libopus", 48000, 48000}}) {
    run_ffmpeg(fmt::format("{} -c:a {} -b:a 192k {}", clicks(c.rate), c.codec, c.name));
    AudioReader reader(file(c.name));
    const Ears ears = read_all(reader);
    EXPECT_EQ(static_cast<int>(ears.left.size()), c.samples) << c.name;
    // A millisecond: the pre-echo of a transform codec moves the middle a little.
    EXPECT_NEAR(centre_of(ears.left), 0.25 * c.rate + 1.5, 0.001 * c.rate) << c.name;
    EXPECT_NEAR(centre_of(ears.right), 0.75 * c.rate + 1.5, 0.001 * c.rate) << c.name;
  }
}

TEST_F(AudioReaderTest, SoundThatBeginsLateBeginsWithSilence) {
  for (const char* name : {"a.mp4", "a.mkv", "a.mov"}) {
    run_ffmpeg(fmt::format(
        "-f lavfi -i testsrc=s=64x48:r=25:d=2 -itsoffset 0.5 {} -c:v libx264 "
        "-bf 0 -c:a pcm_s16le a.mkv && ffmpeg -v error -nostdin -y -i a.mkv "
        "-c:v copy -c:a {} b_{}",
        clicks(44100), std::string(name) == "a.mp4" ? "flac -strict -2" : "copy", name));
    AudioReader reader(file(fmt::format("b_{}", name)));
    // Matroska's clock ticks in milliseconds: half of one, and rounding.
    EXPECT_NEAR(reader.info().start_s, 0.5, 0.0006);
    const Ears ears = read_all(reader);
    // Matroska's clock ticks in milliseconds.
    EXPECT_NEAR(static_cast<double>(ears.left.size()), 1.5 * 44100, 45) << name;
    EXPECT_NEAR(centre_of(ears.left), 0.75 * 44100 + 1.5, 45) << name;
    for (std::size_t i = 0; i < 22000; ++i) ASSERT_EQ(ears.left[i], 0.0F);
  }
}

TEST_F(AudioReaderTest, AGapBetweenTimestampsIsSilence) {
  // Two halves with 0.3 s between them.
  run_ffmpeg(
      fmt::format("{} -af \"asetpts='PTS+gt(T,0.5)*0.3/TB'\" -c:a pcm_s16le a.mkv", clicks(48000)));
  AudioReader reader(file("a.mkv"));
  const Ears ears = read_all(reader);
  EXPECT_NEAR(static_cast<double>(ears.left.size()), 1.3 * 48000, 48);  // one tick
  EXPECT_NEAR(centre_of(ears.left), 0.25 * 48000 + 1.5, 1.0);
  EXPECT_NEAR(centre_of(ears.right), 1.05 * 48000 + 1.5, 48);
}

TEST_F(AudioReaderTest, BlocksOfAnySizeGiveTheSameSamples) {
  run_ffmpeg(fmt::format("{} -c:a aac a.m4a", clicks(44100)));
  AudioReader whole(file("a.m4a"));
  const Ears expected = read_all(whole, 100000);
  for (const std::ptrdiff_t block : {1, 100, 1024, 4097}) {
    AudioReader reader(file("a.m4a"));
    const Ears ears = read_all(reader, block);
    EXPECT_EQ(ears.left, expected.left);
    EXPECT_EQ(ears.right, expected.right);
  }
}

TEST_F(AudioReaderTest, NotTwoChannelsNamesTheStreamAndTheMend) {
  run_ffmpeg(
      "-f lavfi -i testsrc=s=64x48:r=25:d=1 -f lavfi -i sine=d=1 -c:v libx264 -c:a aac a.mp4");
  const std::string mono = input_error([&] { AudioReader(file("a.mp4")); });
  EXPECT_TRUE(mentions(mono, "a.mp4: audio stream 1")) << mono;
  EXPECT_TRUE(mentions(mono, "mono")) << mono;
  EXPECT_TRUE(mentions(mono, "channel of each ear, 0,0")) << mono;

  run_ffmpeg("-f lavfi -i anoisesrc=d=1:r=48000 -af 'pan=5.1|c0=c0|c2=0.5*c0' -c:a aac b.m4a");
  const std::string surround = input_error([&] { AudioReader(file("b.m4a")); });
  EXPECT_TRUE(mentions(surround, "audio stream 0: has 6 channels (5.1)")) << surround;
  EXPECT_TRUE(mentions(surround, "channel of each ear, left and right, e.g. 0,1")) << surround;
}

TEST_F(AudioReaderTest, PicksTheNamedChannels) {
  // Four channels that hold 0.1, 0.2, 0.3, 0.4.
  run_ffmpeg("-f lavfi -i \"aevalsrc='0.1|0.2|0.3|0.4':s=16000:d=0.5:c=4.0\" -c:a pcm_f32le a.wav");
  AudioReader reader(file("a.wav"), std::array{3, 1});
  const Ears ears = read_all(reader);
  ASSERT_EQ(ears.left.size(), 8000U);
  EXPECT_FLOAT_EQ(ears.left[100], 0.4F);
  EXPECT_FLOAT_EQ(ears.right[100], 0.2F);
  for (const std::array<int, 2> wrong : {std::array{0, 4}, std::array{-1, 0}}) {
    const std::string message = input_error([&] { AudioReader(file("a.wav"), wrong); });
    EXPECT_TRUE(mentions(message, "from 0 to 3")) << message;
  }
  // Also of a planar format, and with the ears swapped.
  run_ffmpeg(fmt::format("{} -c:a flac b.flac", clicks(16000)));
  AudioReader swapped(file("b.flac"), std::array{1, 0});
  EXPECT_EQ(read_all(swapped).right[4000], 0.5F);
}

TEST_F(AudioReaderTest, PicksTheNamedStream) {
  run_ffmpeg(
      "-f lavfi -i testsrc=s=64x48:r=25:d=1 -f lavfi -i sine=d=1 "
      "-f lavfi -i sine=d=1:r=16000 -map 0 -map 1 -map 2 -ac 2 -c:v libx264 -c:a pcm_s16le "
      "a.mov");
  EXPECT_EQ(AudioReader(file("a.mov")).sample_rate_hz(), 44100);
  EXPECT_EQ(AudioReader(file("a.mov"), {}, 2).sample_rate_hz(), 16000);
  const std::string message = input_error([&] { AudioReader(file("a.mov"), {}, 0); });
  EXPECT_TRUE(mentions(message, "stream 0 is not an audio stream")) << message;
  EXPECT_TRUE(mentions(message, "an audio stream from 1, 2")) << message;
}

TEST_F(AudioReaderTest, SilenceNanAndLoudSamplesPassUnjudged) {
  const std::vector<float> samples = {0.0F, NAN, 3.5F, -INFINITY, 0.25F, 0.0F};
  std::string raw(samples.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), samples.data(), raw.size());
  write_file(file("raw"), raw);
  run_ffmpeg("-f f32le -ar 16000 -ac 2 -i raw -c copy a.wav");
  AudioReader reader(file("a.wav"));
  const Ears ears = read_all(reader);
  ASSERT_EQ(ears.left.size(), 3U);
  EXPECT_TRUE(std::isnan(ears.right[0]));
  EXPECT_EQ(ears.left[1], 3.5F);
  EXPECT_TRUE(std::isinf(ears.right[1]));
}

TEST_F(AudioReaderTest, NoSoundIsToldSo) {
  run_ffmpeg("-f lavfi -i testsrc=s=64x48:r=25:d=1 -c:v libx264 a.mp4");
  EXPECT_EQ(input_error([&] { AudioReader(file("a.mp4")); }),
            file("a.mp4").string() + ": has no audio stream");
  run_ffmpeg("-f lavfi -i sine=d=1 -ac 2 -t 0 b.wav");
  const std::string empty = input_error([&] { AudioReader(file("b.wav")); });
  EXPECT_TRUE(mentions(empty, "b.wav")) << empty;
}

TEST_F(AudioReaderTest, DamageIsToldWithStreamAndTime) {
  run_ffmpeg("-f lavfi -i anoisesrc=d=3:r=44100 -ac 2 -c:a aac -movflags +faststart a.m4a");
  std::string sound = read_text_file(file("a.m4a"));
  for (std::size_t i = sound.size() / 2; i < sound.size() / 2 + 3000; ++i) sound[i] = '\x5a';
  write_file(file("b.m4a"), sound);
  AudioReader damaged(file("b.m4a"));
  const std::string message = input_error([&] { read_all(damaged); });
  EXPECT_TRUE(mentions(message, "b.m4a: audio stream 0 at 1.")) << message;

  for (const char* name : {"c.m4a", "c.mkv", "c.wav"}) {
    run_ffmpeg(fmt::format("-i a.m4a -c:a {} -movflags +faststart {}",
                           std::string(name) == "c.wav" ? "pcm_s16le" : "copy", name));
    const std::string whole = read_text_file(file(name));
    write_file(file(name), whole.substr(0, whole.size() / 2));
    const std::string cut = input_error([&] {
      AudioReader reader(file(name));
      read_all(reader);
    });
    EXPECT_TRUE(mentions(cut, "audio stream 0 at 1.")) << name << ": " << cut;
  }
}

}  // namespace
}  // namespace earpoint
