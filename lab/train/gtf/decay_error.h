#pragma once

#include <ATen/core/Tensor.h>

namespace earpoint {

/// How far the decay of what a room, or a network, does to dry speech is off: the response from dry
/// to heard sound is found by regularised division of spectra, its energy is summed backwards, and
/// the curves are compared in dB from the direct sound to 150 ms behind it, down to 20 dB: the part
/// that early decay time and clarity are read from. What is not a filter of the speech, such as a
/// gain that follows it, ends up as noise all over the response and counts as decay, too.
/// @param dry           [clips][samples], at least 0.16 s
/// @param found, right  [clips][2][samples]
/// @return mean absolute difference in dB
at::Tensor decay_error_db(const at::Tensor& dry, const at::Tensor& found, const at::Tensor& right);

}  // namespace earpoint
