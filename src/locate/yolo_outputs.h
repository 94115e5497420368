#pragma once

#include <span>
#include <vector>

#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// Which of the known forms a detector's output has.
enum class YoloLayout {
  yolov8,  ///< [4 + classes][places]: middle and size in pixels, scores
  yolox,   ///< [places][5 + classes]: by the place's grid; whether there is anything; scores
};

/// How many places a detector of that input has: a grid each at an 8th, a 16th and a 32nd.
[[nodiscard]] int yolo_places(int height, int width);

/// Reads the people out of an output.
/// @param output       as the layout has it
/// @param places       yolo_places()
/// @param height, width  of the network's input, pixels
/// @return boxes in pixels of the input, before non-maximum suppression; those of which the network
///         is at least `least_score` sure
[[nodiscard]] std::vector<DetectedPerson> yolo_people(std::span<const float> output,
                                                      YoloLayout layout, int places, int height,
                                                      int width, double least_score);

}  // namespace earpoint
