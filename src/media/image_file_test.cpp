#include "test_media.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

class ImageFile : public MediaTest {
 protected:
  /// A PNG made by ffmpeg from raw pixels.
  void make_png(const std::string& name, const std::string& pixel_format, int width, int height,
                std::string_view raw) const {
    write_file(file("raw"), raw);
    run_ffmpeg(fmt::format("-f rawvideo -pix_fmt {0} -s {1}x{2} -i raw -pix_fmt {0} {3}",
                           pixel_format, width, height, name));
  }
};

Image noise(int width, int height, int channels) {
  RandomStream random(7);
  Image image(width, height, channels);
  for (std::uint8_t& value : image.pixels()) value = static_cast<std::uint8_t>(random.index(256));
  return image;
}

/// Colours that change slowly, which suits JPEG.
Image gradient(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = static_cast<std::uint8_t>(255 * x / width);
      image.at(x, y, 1) = static_cast<std::uint8_t>(255 * y / height);
      image.at(x, y, 2) = 200;
    }
  }
  return image;
}

int largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.width(), b.width());
  EXPECT_EQ(a.height(), b.height());
  int largest = 0;
  for (std::size_t i = 0; i < std::min(a.pixels().size(), b.pixels().size()); ++i) {
    largest = std::max(largest, std::abs(int{a.pixels()[i]} - int{b.pixels()[i]}));
  }
  return largest;
}

std::string bytes_of(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes.push_back(static_cast<char>(value));
  return bytes;
}

TEST_F(ImageFile, PngGivesEveryPixelBack) {
  // Odd sizes: rows that do not fill a vector register.
  for (const int width : {1, 3, 33, 257}) {
    const Image image = noise(width, 19, 3);
    write_image(file("a.png"), image);
    const Image read = read_image(file("a.png"));
    EXPECT_EQ(read.channels(), 3);
    EXPECT_EQ(largest_difference(read, image), 0) << width;
  }
  EXPECT_EQ(entries(), 1);
}

TEST_F(ImageFile, DecodesFromMemoryWhatItReadsFromAFile) {
  const Image image = noise(37, 21, 3);
  write_image(file("a.png"), image);
  EXPECT_EQ(largest_difference(decode_image(read_file(file("a.png")), "a texture"), image), 0);
  EXPECT_EQ(read_file(file("a.png")), encode_png(image));
}

TEST_F(ImageFile, GreyComesBackAsEqualRedGreenAndBlue) {
  const Image grey = noise(31, 9, 1);
  write_image(file("a.png"), grey);
  const Image read = read_image(file("a.png"));
  ASSERT_EQ(read.channels(), 3);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 31; ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(read.at(x, y, c), grey.at(x, y));
    }
  }
}

TEST_F(ImageFile, JpegIsCloseAndKeepsItsColourResolution) {
  const Image image = gradient(120, 80);
  for (const char* name : {"a.jpg", "b.JPEG"}) {
    write_image(file(name), image);
    // Quantisation at this quality: a few levels of 255.
    EXPECT_LE(largest_difference(read_image(file(name)), image), 6) << name;
  }
  // Red and blue columns, one pixel wide, would mix to magenta with chroma subsampling, 128 levels
  // off. Such hard edges lose more by quantisation than the gradient.
  Image columns(64, 16, 3);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) columns.at(x, y, x % 2 == 0 ? 0 : 2) = 255;
  }
  write_image(file("c.jpg"), columns);
  EXPECT_LE(largest_difference(read_image(file("c.jpg")), columns), 40);
}

TEST_F(ImageFile, SixteenBitsAreRoundedToEight) {
  // Big-endian: 0, 65535, 128 (rounds to 0), 129 (to 1), 0x8000 (to 128), 0x7fff (to 127).
  make_png("a.png", "gray16be", 6, 1,
           bytes_of({0, 0, 0xff, 0xff, 0, 128, 0, 129, 0x80, 0, 0x7f, 0xff}));
  const Image grey = read_image(file("a.png"));
  EXPECT_EQ(grey.at(0, 0), 0);
  EXPECT_EQ(grey.at(1, 0), 255);
  EXPECT_EQ(grey.at(2, 0), 0);
  EXPECT_EQ(grey.at(3, 0), 1);
  EXPECT_EQ(grey.at(4, 0, 2), 128);
  EXPECT_EQ(grey.at(5, 0, 1), 127);

  make_png("b.png", "rgb48be", 1, 1, bytes_of({0xff, 0xff, 0x80, 0, 0, 0}));
  const Image rgb = read_image(file("b.png"));
  EXPECT_EQ(rgb.at(0, 0, 0), 255);
  EXPECT_EQ(rgb.at(0, 0, 1), 128);
  EXPECT_EQ(rgb.at(0, 0, 2), 0);
}

TEST_F(ImageFile, TransparencyIsCompositedOnBlack) {
  make_png("a.png", "rgba", 3, 1,
           bytes_of({200, 100, 50, 255, 200, 100, 50, 0, 200, 100, 50, 128}));
  const Image read = read_image(file("a.png"));
  EXPECT_EQ(read.at(0, 0, 0), 200);
  EXPECT_EQ(read.at(0, 0, 2), 50);
  EXPECT_EQ(read.at(1, 0, 0), 0);
  EXPECT_EQ(read.at(2, 0, 0), 100);  // 200 * 128 / 255 = 100.4
  EXPECT_EQ(read.at(2, 0, 1), 50);

  make_png("b.png", "ya8", 2, 1, bytes_of({90, 255, 90, 0}));
  const Image grey = read_image(file("b.png"));
  EXPECT_EQ(grey.at(0, 0, 1), 90);
  EXPECT_EQ(grey.at(1, 0, 1), 0);
}

TEST_F(ImageFile, PaletteAndSingleBitsBecomeColours) {
  Image image(4, 2, 3);
  image.at(1, 0, 0) = 255;
  image.at(2, 1, 2) = 77;
  write_image(file("rgb.png"), image);
  run_ffmpeg(
      "-i rgb.png -vf 'split[a][b];[a]palettegen=reserve_transparent=0[p];"
      "[b][p]paletteuse=dither=none' -pix_fmt pal8 a.png");
  EXPECT_EQ(largest_difference(read_image(file("a.png")), image), 0);

  make_png("b.png", "monob", 8, 1, bytes_of({0b10100000}));
  const Image bits = read_image(file("b.png"));
  EXPECT_EQ(bits.at(0, 0), 255);
  EXPECT_EQ(bits.at(1, 0), 0);
  EXPECT_EQ(bits.at(2, 0, 2), 255);
}

/// Puts Exif data with an orientation behind the first marker of a JPEG file.
void add_exif_orientation(const std::filesystem::path& path, int orientation) {
  std::string exif =
      bytes_of({0xff, 0xe1, 0, 34, 'E',  'x',  'i', 'f', 0, 0, 'M', 'M', 0, 42,          0, 0,
                0,    8,    0, 1,  0x01, 0x12, 0,   3,   0, 0, 0,   1,   0, orientation, 0, 0});
  exif += bytes_of({0, 0, 0, 0});
  std::string jpeg = read_text_file(path);
  jpeg.insert(2, exif);
  write_file(path, jpeg);
}

std::string big_endian(std::uint32_t value) {
  return bytes_of({static_cast<int>(value >> 24), static_cast<int>(value >> 16 & 0xff),
                   static_cast<int>(value >> 8 & 0xff), static_cast<int>(value & 0xff)});
}

/// Puts an eXIf chunk with an orientation behind a PNG file's header.
void add_exif_chunk(const std::filesystem::path& path, int orientation) {
  const std::string exif = bytes_of({'M', 'M', 0, 42, 0, 0, 0,           8, 0, 1, 0x01, 0x12, 0,
                                     3,   0,   0, 0,  1, 0, orientation, 0, 0, 0, 0,    0,    0});
  const std::string chunk = "eXIf" + exif;
  std::uint32_t crc = 0xffffffff;
  for (const char c : chunk) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320U : 0U);
  }
  constexpr std::size_t kHeaderEnd = 8 + 25;
  std::string png = read_text_file(path);
  png.insert(kHeaderEnd,
             big_endian(static_cast<std::uint32_t>(exif.size())) + chunk + big_endian(~crc));
  write_file(path, png);
}

TEST_F(ImageFile, ExifOrientationIsApplied) {
  // Left half red, right half blue, a green top edge: every side is marked.
  Image upright(64, 32, 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) upright.at(x, y, y < 8 ? 1 : x < 32 ? 0 : 2) = 255;
  }
  // Stored for orientation 6: rotated by 90 degrees to the left.
  Image stored(32, 64, 3);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) stored.at(y, 63 - x, c) = upright.at(x, y, c);
    }
  }
  write_image(file("a.jpg"), stored);
  add_exif_orientation(file("a.jpg"), 6);
  const Image read = read_image(file("a.jpg"));
  ASSERT_EQ(read.width(), 64);
  EXPECT_GT(read.at(10, 2, 1), 200);
  EXPECT_GT(read.at(10, 20, 0), 200);
  EXPECT_GT(read.at(50, 20, 2), 200);

  write_image(file("a.png"), stored);
  add_exif_chunk(file("a.png"), 6);
  const Image turned = read_image(file("a.png"));
  EXPECT_TRUE(std::ranges::equal(turned.pixels(), upright.pixels()));
}

TEST_F(ImageFile, TheLensTellsTheFieldOfView) {
  // Big endian; one entry, which points to a second directory with the focal length of 24 mm.
  std::string exif = bytes_of({0xff, 0xe1, 0,    2 + 6 + 8 + 2 + 12 + 4 + 2 + 12 + 4,
                               'E',  'x',  'i',  'f',
                               0,    0,    'M',  'M',
                               0,    42,   0,    0,
                               0,    8,    0,    1,
                               0x87, 0x69, 0,    4,
                               0,    0,    0,    1,
                               0,    0,    0,    26,
                               0,    0,    0,    0,
                               0,    1,    0xA4, 0x05,
                               0,    3,    0,    0,
                               0,    1,    0,    24,
                               0,    0,    0,    0,
                               0,    0});
  write_image(file("a.jpg"), Image(64, 48, 3));
  std::string jpeg = read_text_file(file("a.jpg"));
  EXPECT_FALSE(probe_media(file("a.jpg")).streams.at(0).horizontal_fov_rad);
  write_file(file("a.jpg"), jpeg.insert(2, exif));
  // 2 atan(43.27 / 48 x 0.8): 71.6 degrees, as a phone's main camera has; to 0.06 degrees.
  EXPECT_NEAR(probe_media(file("a.jpg")).streams.at(0).horizontal_fov_rad.value(), 1.2497, 1e-3);

  run_ffmpeg(
      "-f lavfi -i testsrc2=s=64x48:r=25:d=0.2 -movflags use_metadata_tags -metadata "
      "com.apple.quicktime.camera.focal_length.35mm_equivalent=24 a.mov");
  // The same focal length; the number above has five digits.
  EXPECT_NEAR(probe_media(file("a.mov")).streams.at(0).horizontal_fov_rad.value(), 1.2497, 1e-3);
}

TEST_F(ImageFile, CutShortOrOverwrittenFilesAreRefused) {
  const Image image = noise(80, 60, 3);
  for (const char* name : {"a.png", "a.jpg"}) {
    write_image(file(name), image);
    const std::string whole = read_text_file(file(name));
    for (const double part : {0.001, 0.01, 0.3, 0.6, 0.9, 0.995}) {
      const auto size = static_cast<std::size_t>(part * static_cast<double>(whole.size()));
      write_file(file(name), whole.substr(0, size));
      const std::string message = input_error([&] { (void)read_image(file(name)); });
      EXPECT_TRUE(mentions(message, name)) << name << " " << part << ": " << message;
    }
  }
  write_image(file("a.png"), image);
  std::string flipped = read_text_file(file("a.png"));
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 0x10);
  write_file(file("a.png"), flipped);
  EXPECT_TRUE(mentions(input_error([&] { (void)read_image(file("a.png")); }), "damaged"));
}

/// The checksum of PNG chunks (ISO 3309).
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320 & (0U - (crc & 1U)));
  }
  return ~crc;
}

TEST_F(ImageFile, HugeDimensionsAreRefusedBeforeMemoryIsTaken) {
  write_image(file("a.png"), Image(4, 4, 3));
  std::string png = read_text_file(file("a.png"));
  const std::string side = bytes_of({0, 0, 0xea, 0x60});  // 60000
  png.replace(16, 8, side + side);
  const std::uint32_t crc = crc32(std::string_view(png).substr(12, 17));
  png.replace(29, 4,
              bytes_of({static_cast<int>(crc >> 24), static_cast<int>(crc >> 16 & 0xff),
                        static_cast<int>(crc >> 8 & 0xff), static_cast<int>(crc & 0xff)}));
  write_file(file("a.png"), png);
  const std::string message = input_error([&] { (void)read_image(file("a.png")); });
  EXPECT_TRUE(mentions(message, "60000x60000")) << message;
}

TEST_F(ImageFile, OtherFilesAreRefusedByName) {
  write_file(file("a.png"), "this is no picture");
  write_file(file("b.png"), "");
  for (const auto& [bytes, kind] : {std::pair{std::string("\0\0\0\x1c"
                                                          "ftypheic\0\0\0\0",
                                                          16),
                                              "HEIC"},
                                    {std::string("RIFF\x10\0\0\0WEBPVP8 ", 16), "WebP"},
                                    {std::string("GIF89a\1\0\1\0", 10), "GIF"},
                                    {std::string("II*\0\x08\0\0\0", 8), "TIFF"}}) {
    write_file(file("q"), bytes);
    for (const std::string& message : {input_error([&] { (void)read_image(file("q")); }),
                                       input_error([&] { (void)probe_media(file("q")); })}) {
      EXPECT_TRUE(mentions(message, std::string("is a ") + kind) &&
                  mentions(message, "PNG and JPEG are read"))
          << message;
    }
  }
  EXPECT_TRUE(mentions(input_error([&] { (void)read_image(file("a.png")); }), "neither a PNG"));
  EXPECT_TRUE(mentions(input_error([&] { (void)read_image(file("b.png")); }), "empty"));
  EXPECT_TRUE(mentions(input_error([&] { (void)read_image(file("c.png")); }), "no such file"));
  EXPECT_TRUE(mentions(input_error([&] { write_image(file("a.bmp"), Image(1, 1, 3)); }), ".png"));
  EXPECT_TRUE(
      mentions(input_error([&] { write_image(file("x/a.png"), Image(1, 1, 3)); }), "folder"));
  EXPECT_THROW(write_image(file("d.png"), Image(0, 0, 3)), std::logic_error);
  EXPECT_THROW(write_image(file("d.png"), Image(2, 2, 4)), std::logic_error);
}

TEST_F(ImageFile, SameImageGivesTheSameBytes) {
  const Image image = noise(40, 30, 3);
  for (const char* name : {"a.png", "a.jpg"}) {
    write_image(file(name), image);
    const std::string first = read_text_file(file(name));
    write_image(file(name), image);
    EXPECT_EQ(read_text_file(file(name)), first);
  }
}

}  // namespace
}  // namespace earpoint
