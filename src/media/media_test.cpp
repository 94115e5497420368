#include "test_media.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <earpoint/media/media.h>

namespace earpoint {
namespace {

class ProbeMedia : public MediaTest {};

constexpr const char* kPicture = "-f lavfi -i testsrc=s=64x48:r=25:d=2";
constexpr const char* kSound = "-f lavfi -i sine=440:r=44100:d=2";

TEST_F(ProbeMedia, ListsTheStreamsOfEveryContainer) {
  struct Case {
    const char* name;
    const char* codecs;
    const char* video;
    const char* audio;
    int rate;
  };
  for (const Case& c : {Case{"a.mp4", "-c:v libx264 -c:a aac", "h264", "aac", 44100},
                        Case{"a.mkv", "-c:v ffv1 -c:a flac", "ffv1", "flac", 44100},
                        Case{"a.webm", "-c:v libvpx-vp9 -c:a libopus", "vp9", "opus", 48000},
                        Case{"a.mov", "-c:v mjpeg -c:a pcm_s24le", "mjpeg", "pcm_s24le", 44100}}) {
    run_ffmpeg(fmt::format("{} {} {} -ac 2 {}", kPicture, kSound, c.codecs, c.name));
    const MediaInfo info = probe_media(file(c.name));
    EXPECT_EQ(info.kind, MediaKind::movie);
    ASSERT_EQ(info.streams.size(), 2U);
    ASSERT_TRUE(info.duration_s.has_value());
    EXPECT_NEAR(*info.duration_s, 2.0, 0.03) << c.name;  // one frame of Opus or AAC

    const StreamInfo& video = *info.preferred(StreamKind::video);
    EXPECT_EQ(video.index, 0);
    EXPECT_EQ(video.codec, c.video);
    EXPECT_EQ(video.width, 64);
    EXPECT_EQ(video.height, 48);
    EXPECT_DOUBLE_EQ(video.frame_rate_hz, 25.0);

    const StreamInfo& audio = *info.preferred(StreamKind::audio);
    EXPECT_EQ(audio.index, 1);
    EXPECT_EQ(audio.codec, c.audio);
    EXPECT_EQ(audio.channels, 2);
    EXPECT_EQ(audio.channel_layout, "stereo");
    EXPECT_EQ(audio.sample_rate_hz, c.rate);
  }
}

TEST_F(ProbeMedia, TellsSoundsAndPicturesFromMovies) {
  run_ffmpeg(fmt::format("{} a.flac", kSound));
  const MediaInfo sound = probe_media(file("a.flac"));
  EXPECT_EQ(sound.kind, MediaKind::sound);
  EXPECT_EQ(sound.preferred(StreamKind::video), nullptr);
  EXPECT_NEAR(sound.duration_s.value(), 2.0, 1e-6);

  for (const char* name : {"a.png", "a.jpg"}) {
    run_ffmpeg(fmt::format("{} -frames:v 1 {}", kPicture, name));
    const MediaInfo picture = probe_media(file(name));
    EXPECT_EQ(picture.kind, MediaKind::picture);
    EXPECT_EQ(picture.streams.at(0).width, 64);
    EXPECT_FALSE(picture.duration_s.has_value());
  }
}

TEST_F(ProbeMedia, ACoverIsNoMovie) {
  run_ffmpeg(fmt::format("{} -frames:v 1 cover.png", kPicture));
  run_ffmpeg(fmt::format(
      "{} -i cover.png -map 0 -map 1 -c:v copy -disposition:v attached_pic a.m4a", kSound));
  const MediaInfo info = probe_media(file("a.m4a"));
  EXPECT_EQ(info.kind, MediaKind::sound);
  ASSERT_NE(info.preferred(StreamKind::attached_picture), nullptr);
  EXPECT_TRUE(mentions(input_error([&] { FrameReader(file("a.m4a")); }), "has no video stream"));
  EXPECT_EQ(AudioReader(file("a.m4a"), std::array{0, 0}).sample_rate_hz(), 44100);
}

TEST_F(ProbeMedia, PrefersTheStreamThatIsMarkedAsDefault) {
  run_ffmpeg(
      fmt::format("{0} {0} -map 0 -map 1 -c:a flac -disposition:a:0 0 "
                  "-disposition:a:1 default a.mkv",
                  kSound));
  EXPECT_EQ(probe_media(file("a.mkv")).preferred(StreamKind::audio)->index, 1);
}

TEST_F(ProbeMedia, BadFilesAreNamed) {
  write_file(file("a.mp4"), "no movie at all");
  write_file(file("b.mp4"), "");
  run_ffmpeg(fmt::format("{} c.gif", kPicture));
  const auto message = [&](const char* name) {
    return input_error([&] { (void)probe_media(file(name)); });
  };
  EXPECT_TRUE(mentions(message("a.mp4"), "a.mp4: ")) << message("a.mp4");
  EXPECT_TRUE(mentions(message("b.mp4"), "b.mp4: is empty"));
  EXPECT_TRUE(mentions(message("c.gif"), "GIF")) << message("c.gif");
  EXPECT_TRUE(mentions(message("missing.mp4"), "no such file"));
  EXPECT_TRUE(mentions(message("."), "is not a file"));
  ASSERT_EQ(mkfifo(file("pipe.mp4").c_str(), 0600), 0);
  EXPECT_TRUE(mentions(message("pipe.mp4"), "is not a file"));
}

TEST_F(ProbeMedia, OpensNoOtherFileOrAddressThatAFileRefersTo) {
  run_ffmpeg(fmt::format("{} secret.ts", kPicture));
  write_file(file("a.m3u8"), "#EXTM3U\n#EXTINF:2,\nsecret.ts\n#EXT-X-ENDLIST\n");
  write_file(file("b.mp4"), "ffconcat version 1.0\nfile secret.ts\n");
  for (const char* name : {"a.m3u8", "b.mp4"}) {
    EXPECT_TRUE(mentions(input_error([&] { FrameReader(file(name)); }), name)) << name;
  }
}

}  // namespace
}  // namespace earpoint
