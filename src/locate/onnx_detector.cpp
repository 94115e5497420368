#include "onnx_detector.h"

#include "onnx_input.h"
#include "yolo_outputs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/resize.h>
#include <earpoint/error.h>
#include <earpoint/locate/box_overlap.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr OnnxInput kUsualInput{640, 640};
constexpr double kLeastScore = 0.35;
constexpr double kMostOverlap = 0.5;
constexpr float kGrey = 114.0F;  // the padding that both were trained with

/// Where a picture lies in the network's input: proportions kept, grey around it.
struct Letterbox {
  int width = 0;  ///< of the picture within
  int height = 0;
  int left = 0;
  int top = 0;
};

Letterbox letterbox(const Image& picture, const OnnxInput& input, YoloLayout layout) {
  const double scale = std::min(static_cast<double>(input.width) / picture.width(),
                                static_cast<double>(input.height) / picture.height());
  const auto size = [&](int pixels) {
    return std::max(1, static_cast<int>(std::lround(scale * pixels)));
  };
  Letterbox box{size(picture.width()), size(picture.height()), 0, 0};
  if (layout == YoloLayout::yolov8) {
    box.left = (input.width - box.width) / 2;
    box.top = (input.height - box.height) / 2;
  }
  return box;
}

class OnnxDetector : public PeopleDetector {
 public:
  OnnxDetector(const fs::path& path, int threads) : name_(path.filename().string()) {
    const std::string where = path.string();
    const std::vector<std::byte> bytes = read_file(path);
    input_ = onnx_input(bytes, where).value_or(kUsualInput);
    // Errors arrive as exceptions.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::setNumThreads(threads);
    try {
      net_ = cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
      layout_ = layout_of(run(std::vector<float>(floats())), where);
    } catch (const cv::Exception& error) {
      throw InputError(where, fmt::format("OpenCV cannot run it: {}", first_line(error.err)));
    }
  }

  [[nodiscard]] std::vector<DetectedPerson> detect(const Image& picture) override {
    EARPOINT_CHECK(!picture.empty() && picture.channels() == 3);
    const Letterbox within = letterbox(picture, input_, layout_);
    const cv::Mat output = run(planes(picture, within));
    const std::span<const float> values(output.ptr<float>(), output.total());
    std::vector<DetectedPerson> people =
        yolo_people(values, layout_, yolo_places(input_.height, input_.width), input_.height,
                    input_.width, kLeastScore);
    for (DetectedPerson& person : people) {
      const auto x = [&](double pixel) {
        return std::clamp((pixel - within.left) / within.width, 0.0, 1.0);
      };
      const auto y = [&](double pixel) {
        return std::clamp((pixel - within.top) / within.height, 0.0, 1.0);
      };
      const Box box = person.box;
      person.box = {.x_min = x(box.x_min),
                    .y_min = y(box.y_min),
                    .x_max = x(box.x_max),
                    .y_max = y(box.y_max)};
      person.score = std::min(person.score, 1.0);
    }
    std::erase_if(people, [](const DetectedPerson& person) {
      return !(person.box.x_min < person.box.x_max && person.box.y_min < person.box.y_max);
    });
    return suppress_repeated(std::move(people), kMostOverlap);
  }

  [[nodiscard]] std::string name() const override { return name_; }

 private:
  [[nodiscard]] std::size_t floats() const { return std::size_t{3} * input_.height * input_.width; }

  static std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

  /// @param planes  [3][height][width] of the input
  cv::Mat run(std::vector<float> planes) {
    const std::array shape{1, 3, input_.height, input_.width};
    net_.setInput(cv::Mat(4, shape.data(), CV_32F, planes.data()));
    return net_.forward().clone();
  }

  [[nodiscard]] YoloLayout layout_of(const cv::Mat& output, const std::string& where) const {
    const int places = yolo_places(input_.height, input_.width);
    if (output.dims == 3 && output.size[0] == 1 && output.type() == CV_32F) {
      if (output.size[2] == places && output.size[1] >= 5) return YoloLayout::yolov8;
      if (output.size[1] == places && output.size[2] >= 6) return YoloLayout::yolox;
    }
    std::string shape;
    for (int i = 0; i < output.dims; ++i) shape += fmt::format("[{}]", output.size[i]);
    throw InputError(where, fmt::format("expected outputs of YOLOv8 ([1][5 or more][{0}]) or YOLOX "
                                        "([1][{0}][6 or more]), found {1}",
                                        places, shape));
  }

  /// What the network was trained to see: YOLOv8 red, green, blue, 0 to 1; YOLOX blue, green, red,
  /// 0 to 255.
  [[nodiscard]] std::vector<float> planes(const Image& picture, const Letterbox& within) const {
    const ImagePlanes resized = resize_bilinear(planes_of(picture), within.width, within.height);
    const bool is_yolox = layout_ == YoloLayout::yolox;
    const float scale = is_yolox ? 1.0F : 1.0F / 255.0F;
    std::vector<float> planes(floats(), kGrey * scale);
    for (int channel = 0; channel < 3; ++channel) {
      const int from = is_yolox ? 2 - channel : channel;
      for (int y = 0; y < within.height; ++y) {
        const float* row =
            resized.values.data() + (std::ptrdiff_t{from} * within.height + y) * within.width;
        float* to = planes.data() +
                    (std::ptrdiff_t{channel} * input_.height + y + within.top) * input_.width +
                    within.left;
        for (int x = 0; x < within.width; ++x) to[x] = scale * row[x];
      }
    }
    return planes;
  }

  std::string name_;
  OnnxInput input_;
  cv::dnn::Net net_;
  YoloLayout layout_ = YoloLayout::yolov8;
};

}  // namespace

std::unique_ptr<PeopleDetector> make_onnx_detector(const fs::path& path, int threads) {
  return std::make_unique<OnnxDetector>(path, threads);
}

}  // namespace earpoint
