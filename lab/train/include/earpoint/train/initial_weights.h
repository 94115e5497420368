#pragma once

#include <cstdint>
#include <filesystem>

#include <earpoint/people/description.h>
#include <earpoint/people/weights.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {

/// Weights to start training from, drawn as the released code draws them: the gates' convolutions
/// zero with uniform biases, layers of the gated stack uniform by He's rule, all others uniform
/// within 1 / sqrt(inputs of a neuron). The released code takes an image trunk that was trained on
/// ImageNet; here it is drawn, normal by He's rule over the outputs: see load_image_trunk().
///
/// The same description and seed give the same weights.
/// Source: docs/released-code.md, initial weights; He et al., ICCV 2015.
[[nodiscard]] ViGasWeights initial_vigas_weights(const ViGasDescription& description,
                                                 std::uint64_t seed);

/// Weights with which the network gives back its input nearly unchanged, so that training begins at
/// the error of a mere copy: two channels carry the ears, scaled into the gates' linear range, and
/// skips, residuals and the head undo the scale. All other channels carry random mixtures, and
/// small random weights join them and the conditioning vector to the ears' channels, so that
/// everything learns from the first steps on. The image trunk is drawn as in
/// initial_vigas_weights().
///
/// Sounds may reach full scale; the copy is good to some per cent of their level.
/// @param description  of at least as many channels as ears
[[nodiscard]] ViGasWeights identity_vigas_weights(const ViGasDescription& description,
                                                  std::uint64_t seed);

/// The same for an estimator of reverberation time: convolutions normal by He's rule over the
/// outputs, the last layer uniform within 1 / sqrt(inputs) about half a second.
[[nodiscard]] Rt60EstimatorWeights initial_rt60_weights(const Rt60Description& description,
                                                        std::uint64_t seed);

/// The same for visual acoustic matching: the trunk by He's rule over the outputs, layers uniform
/// within 1 / sqrt(inputs of a neuron), and the last convolution so that the network at first gives
/// back its source.
[[nodiscard]] VamWeights initial_vam_weights(const VamDescription& description, std::uint64_t seed);

/// The same for a network that detects people: convolutions normal by He's rule over the inputs,
/// the last one nearly zero and its bias so it detects nobody.
[[nodiscard]] PeopleWeights initial_people_weights(const PeopleDescription& description,
                                                   std::uint64_t seed);

/// Replaces the image trunk by one trained elsewhere: a ResNet-18 with torchvision's names
/// (`conv1.weight`, `layer1.0.conv1.weight`, ...), as .safetensors or as torch.save wrote it.
/// @throws InputError if the file is neither, or a tensor is missing or has another shape
/// @throws std::logic_error if the network has no image encoder
void load_image_trunk(const std::filesystem::path& path, ViGasWeights& weights);

}  // namespace earpoint
