#pragma once

// For this module's tests: a folder of their own and files made by the ffmpeg program, so that the
// readers meet what other software writes.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {

class MediaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              fmt::format("{}_{}", info->test_suite_name(), info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  /// Runs ffmpeg in the test's folder.
  void run_ffmpeg(const std::string& arguments) const {
    const std::string command = fmt::format(
        "cd '{}' && ffmpeg -v error -nostdin -y {} 2>ffmpeg.log", folder_.string(), arguments);
    // NOLINTNEXTLINE(cert-env33-c): the command is the test's own
    ASSERT_EQ(std::system(command.c_str()), 0) << "ffmpeg " << arguments << "\n"
                                               << read_text_file(file("ffmpeg.log"));
  }

  /// Files in the folder, hidden ones included.
  [[nodiscard]] int entries() const {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

 private:
  std::filesystem::path folder_;
};

/// The message of the InputError that the call throws, which must be one line; empty if none.
template <typename Call>
std::string input_error(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return {};
}

inline bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace earpoint
