#include "network_detector.h"
#if EARPOINT_HAS_OPENCV
#include "onnx_detector.h"
#endif

#include <fmt/format.h>

#include <earpoint/core/data_folder.h>
#include <earpoint/error.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/people/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kShipped = "people.safetensors";
constexpr std::string_view kNanoDet = "nanodet";
constexpr std::string_view kNanoDetFile = "people-nanodet.onnx";

/// A file that `./dev assets --people` installs.
fs::path installed(std::string_view name) {
  const auto folder = data_folder();
  if (folder && fs::exists(*folder / name)) return *folder / name;
  throw InputError("detector 'nanodet'", "is not installed", "run ./dev assets --people");
}

std::unique_ptr<PeopleDetector> own_network(const fs::path& path, int threads) {
  const std::string where = path.string();
  SafetensorsFile file = read_safetensors(path);
  if (network_kind(file, where) != NetworkKind::people) {
    throw InputError(where, "is not a network that detects people",
                     fmt::format("give one like {}, or an .onnx file", kShipped));
  }
  return std::make_unique<NetworkDetector>(people_weights(std::move(file), where),
                                           path.filename().string(), threads);
}

}  // namespace

std::unique_ptr<PeopleDetector> make_people_detector(const std::optional<fs::path>& file,
                                                     int threads) {
  EARPOINT_CHECK(threads > 0);
  if (!file) {
    const auto shipped = shipped_model_path(kShipped);
    if (!shipped) {
      throw InputError(std::string(kShipped), "was not found among the shipped models",
                       "choose another people detector: nanodet (./dev assets --people) or a file");
    }
    return own_network(*shipped, threads);
  }
  if (*file == kNanoDet) return make_people_detector(installed(kNanoDetFile), threads);
  const std::string extension = file->extension().string();
  if (extension == ".safetensors") return own_network(*file, threads);
  if (extension != ".onnx")
    throw InputError(file->string(), "expected nanodet, or a .safetensors or .onnx file");
#if EARPOINT_HAS_OPENCV
  return make_onnx_detector(*file, threads);
#else
  throw InputError(file->string(), "needs OpenCV, and this build has none",
                   "build with -DEARPOINT_OPENCV=ON, or give a .safetensors file");
#endif
}

}  // namespace earpoint
