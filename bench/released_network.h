#pragma once

#include <vector>

#include <earpoint/model/safetensors.h>
#include <earpoint/model/weights.h>

namespace earpoint {

/// A network of the shape that was released for SoundSpaces (30 layers, 64 channels, ResNet-18 on
/// 256 x 256 pixels), with weights drawn so that the sound keeps its level from layer to layer.
ViGasWeights released_network();

/// One second of noise, a picture of noise and a pose for it, by the names of earpoint model run.
SafetensorsFile released_inputs(const ViGasDescription& network);

}  // namespace earpoint
