#pragma once

#include <filesystem>
#include <memory>

#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// A network in an ONNX file that OpenCV runs, class 0 being "person", as in COCO, with the outputs
/// - of YOLOv8: [1][4 + classes][places], middle and size in pixels; or
/// - of YOLOX: [1][places][5 + classes], as its exporter writes them: offsets and logarithms by the
///   place's grid.
/// @param threads  > 0; OpenCV has one number of threads for the whole process
/// @throws InputError if the file cannot be read, or its network has other inputs or outputs
[[nodiscard]] std::unique_ptr<PeopleDetector> make_onnx_detector(const std::filesystem::path& path,
                                                                 int threads);

}  // namespace earpoint
