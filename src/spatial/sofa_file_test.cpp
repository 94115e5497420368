#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/sofa_file.h>

namespace earpoint {
namespace {

// Made by testdata/make_sofa.py: eight directions of a sphere at 48 kHz, one impulse per ear.
std::filesystem::path test_file(const std::string& name) {
  return std::filesystem::path(EARPOINT_SOURCE_DIR) / "src/spatial/testdata" / name;
}

std::string refusal(const std::filesystem::path& path) {
  try {
    static_cast<void>(read_sofa(path));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

// Position of the impulse, with the file's delay.
double delay_of(const SofaFile& file, std::size_t measurement, int ear) {
  const auto response = file.response(measurement, ear);
  for (int tap = 0; tap < file.taps; ++tap) {
    if (response[tap] > 0.1F) return tap + file.delays_samples[measurement][ear];
  }
  return -1.0;
}

void expect_the_sphere(const SofaFile& file) {
  EXPECT_EQ(file.sample_rate_hz, 48000);
  EXPECT_EQ(file.taps, 64);
  ASSERT_EQ(file.positions_m.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    // Eight directions counter-clockwise from the front at 1.5 m; file coordinates are float32.
    const Spherical expected{radians_from_degrees(45.0 * static_cast<double>(i)), 0.0, 1.5};
    EXPECT_NEAR(norm(file.positions_m[i] - cartesian_from_spherical(expected)), 0.0, 1e-6);
  }
  // Direction 2 is left: a/c before the middle of the head at the left ear, (pi/2) a/c after it
  // at the right one, in whole samples: 24 - 12.2 and 24 + 19.2.
  EXPECT_EQ(delay_of(file, 2, 0), 12.0);
  EXPECT_EQ(delay_of(file, 2, 1), 43.0);
  EXPECT_EQ(delay_of(file, 6, 0), 43.0);
  EXPECT_EQ(delay_of(file, 6, 1), 12.0);
  EXPECT_EQ(delay_of(file, 0, 0), 24.0);
}

TEST(SofaFile, ReadsSphericalCoordinates) {
  expect_the_sphere(read_sofa(test_file("sphere.sofa")));
}

TEST(SofaFile, ReadsCartesianCoordinatesSwappedReceiversAndDelays) {
  const SofaFile file = read_sofa(test_file("sphere_cartesian_swapped_delays.sofa"));
  expect_the_sphere(file);
  EXPECT_EQ(file.delays_samples[2][0], 12.0);
}

TEST(SofaFile, ReadsAListenerWhoStandsElsewhereAndLooksAside) {
  expect_the_sphere(read_sofa(test_file("sphere_turned.sofa")));
}

TEST(SofaFile, TheDefaultSetIsKemar) {
  const SofaFile file = read_sofa(default_hrtf_path());
  EXPECT_EQ(file.sample_rate_hz, 44100);
  EXPECT_EQ(file.taps, 512);
  EXPECT_EQ(file.positions_m.size(), 710U);
}

TEST(SofaFile, RefusesEachDefectByName) {
  EXPECT_NE(refusal(test_file("wrong_ears.sofa")).find("swapped"), std::string::npos);
  EXPECT_NE(refusal(test_file("wrong_convention.sofa")).find("GeneralFIR"), std::string::npos);
  EXPECT_NE(refusal(test_file("wrong_value.sofa")).find("Data.IR"), std::string::npos);
  EXPECT_NE(refusal(test_file("wrong_rate.sofa")).find("Data.SamplingRate"), std::string::npos);
  EXPECT_NE(refusal(test_file("nowhere.sofa")).find("nowhere.sofa"), std::string::npos);
  EXPECT_NE(refusal(test_file("make_sofa.py")).find("expected a SOFA file"), std::string::npos);
}

// Writes the sphere's file with bytes replaced, and reads it.
std::string refusal_of_changed(std::string_view from, std::string_view to) {
  std::vector<std::byte> bytes = read_file(test_file("sphere.sofa"));
  const auto same = [](std::byte byte, char c) { return static_cast<char>(byte) == c; };
  bool found = false;
  for (auto at = bytes.begin();; at += std::ssize(to)) {
    at = std::search(at, bytes.end(), from.begin(), from.end(), same);
    if (at == bytes.end()) break;
    found = true;
    std::transform(to.begin(), to.end(), at, [](char c) { return static_cast<std::byte>(c); });
  }
  EXPECT_TRUE(found);
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "changed.sofa";
  write_file(path, std::span<const std::byte>(bytes));
  const std::string message = refusal(path);
  std::filesystem::remove(path);
  return message;
}

TEST(SofaFile, RefusesCoordinatesInOtherUnits) {
  EXPECT_NE(refusal_of_changed("degree, degree, metre", "radian, radian, metre")
                .find("SourcePosition: expected units of degree, degree, metre, found 'radian, "
                      "radian, metre'"),
            std::string::npos);
  // Other spellings are accepted.
  EXPECT_EQ(refusal_of_changed("degree, degree, metre", "Degree,degrees, meter"), "accepted");
}

TEST(SofaFile, RefusesResponsesOfZeros) {
  std::vector<std::byte> bytes = read_file(test_file("sphere.sofa"));
  // Data.IR lies uncompressed in the file: 8 x 2 x 64 doubles.
  constexpr std::size_t kStart = 17713;
  constexpr std::size_t kResponse = 64 * sizeof(double);
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "zeros.sofa";
  const auto with_zeros = [&](std::size_t first, std::size_t count) {
    std::vector<std::byte> changed = bytes;
    std::fill_n(changed.begin() + static_cast<std::ptrdiff_t>(kStart + first * kResponse),
                count * kResponse, std::byte{0});
    write_file(path, std::span<const std::byte>(changed));
    return refusal(path);
  };
  EXPECT_EQ(with_zeros(0, 0), "accepted");
  EXPECT_NE(with_zeros(0, 16).find("Data.IR: measurement 1 has only zeros for the left"),
            std::string::npos);
  EXPECT_NE(with_zeros(5, 1).find("measurement 3 has only zeros for the right ear"),
            std::string::npos);
  std::filesystem::remove(path);
}

TEST(SofaFile, RefusesTruncatedFilesWithOneLine) {
  const std::vector<std::byte> whole = read_file(test_file("sphere.sofa"));
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "truncated.sofa";
  for (const double share : {0.0, 0.0005, 0.01, 0.1, 0.5, 0.9, 0.99}) {
    const auto bytes = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
    write_file(path, std::span(whole).first(bytes));
    const std::string message = refusal(path);
    EXPECT_NE(message.find("truncated.sofa"), std::string::npos) << share << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  std::filesystem::remove(path);
}

TEST(SofaFile, RefusesDamageThatCrashesTheReadingLibrary) {
  const std::vector<std::byte> whole = read_file(test_file("sphere.sofa"));
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "damaged.sofa";
  // Seeds whose bytes crash libmysofa 1.3.1, by invalid reads and a stack overflow.
  for (const std::uint64_t seed : {77U, 131U, 167U, 387U}) {
    std::vector<std::byte> bytes = whole;
    RandomStream random(seed);
    const std::uint64_t changes = 1 + random.index(8);
    for (std::uint64_t i = 0; i < changes; ++i) {
      const auto value = static_cast<std::byte>(random.index(256));
      bytes[random.index(seed % 2 == 0 ? bytes.size() : 20000)] = value;
    }
    write_file(path, bytes);
    EXPECT_NE(refusal(path).find("damaged.sofa: the SOFA file is damaged"), std::string::npos)
        << seed;
  }
  std::filesystem::remove(path);
}

TEST(SofaFile, ClassicNetcdfIsNamed) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "classic.sofa";
  write_file(path, std::string_view("CDF\x01 and so on"));
  EXPECT_NE(refusal(path).find("nccopy"), std::string::npos);
  std::filesystem::remove(path);
}

TEST(DefaultHrtf, FollowsTheEnvironment) {
  ASSERT_EQ(setenv("EARPOINT_HRTF", "/of/my/own.sofa", 1), 0);
  EXPECT_EQ(default_hrtf_path(), "/of/my/own.sofa");
  ASSERT_EQ(unsetenv("EARPOINT_HRTF"), 0);
  EXPECT_EQ(default_hrtf_path().filename(), "MIT_KEMAR_normal_pinna.sofa");
}

}  // namespace
}  // namespace earpoint
