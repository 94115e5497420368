#pragma once

#include <cstdint>

#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// Weights of a network, drawn so that the sound keeps its level from layer to layer.
ViGasWeights drawn_network(const ViGasDescription& description);

/// A network of the shape that was released for SoundSpaces (30 layers, 64 channels, ResNet-18 on
/// 256 x 256 pixels), with drawn weights.
ViGasWeights released_network();

/// Noise as long as the network's window, a picture of noise and a pose for each clip, by the names
/// of earpoint model run.
SafetensorsFile drawn_inputs(const ViGasDescription& network, std::int64_t clips);

}  // namespace earpoint
