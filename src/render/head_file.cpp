#include <earpoint/render/head_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {
namespace {

constexpr const char* kRate = "sample_rate_hz";
constexpr int kLowestRate_hz = 8000;  // as read_sofa()
constexpr int kHighestRate_hz = 192000;

Tensor tensor_of(const std::vector<float>& values, std::vector<std::int64_t> shape) {
  return make_tensor(std::span<const float>(values), std::move(shape));
}

/// A tensor's values, checked: as many axes as `shape` has, and where that is not 0, of that
/// length.
const Tensor& checked(const SafetensorsFile& file, const char* name,
                      const std::vector<std::int64_t>& shape, std::string_view where) {
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end()) {
    throw InputError(where, fmt::format("has no tensor '{}'", name));
  }
  const Tensor& tensor = found->second;
  bool fits = tensor.dtype == DType::f32 && tensor.shape.size() == shape.size();
  for (std::size_t axis = 0; fits && axis < shape.size(); ++axis) {
    fits = tensor.shape[axis] > 0 && (shape[axis] == 0 || tensor.shape[axis] == shape[axis]);
  }
  if (!fits) {
    throw InputError(fmt::format("{}: tensor '{}'", where, name),
                     fmt::format("expected F32 {}, found {} {}", to_string(shape),
                                 name_of(tensor.dtype), to_string(tensor.shape)));
  }
  const std::span<const float> values = tensor.as<float>();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    throw InputError(fmt::format("{}: tensor '{}'", where, name), "has NaN or infinite values");
  }
  return tensor;
}

}  // namespace

SafetensorsFile to_head_file(const SofaFile& head) {
  const auto count = static_cast<std::int64_t>(head.positions_m.size());
  std::vector<float> positions_m;
  std::vector<float> delays;
  for (const Vector3& position_m : head.positions_m) {
    for (const double coordinate_m : {position_m.x, position_m.y, position_m.z}) {
      positions_m.push_back(static_cast<float>(coordinate_m));
    }
  }
  for (const std::array<double, 2>& delay : head.delays_samples) {
    for (const double samples : delay) delays.push_back(static_cast<float>(samples));
  }
  SafetensorsFile file;
  file.metadata[kRate] = fmt::format("{}", head.sample_rate_hz);
  file.tensors["positions_m"] = tensor_of(positions_m, {count, 3});
  file.tensors["responses"] = tensor_of(head.responses, {count, 2, head.taps});
  file.tensors["delays_samples"] = tensor_of(delays, {count, 2});
  return file;
}

bool is_head_file(const SafetensorsFile& file) { return file.metadata.contains(kRate); }

SofaFile read_head_file(const SafetensorsFile& file, std::string_view where) {
  EARPOINT_CHECK(is_head_file(file));
  SofaFile head;
  const std::string& rate = file.metadata.at(kRate);
  const bool is_number =
      !rate.empty() && rate.size() <= 6 &&
      std::all_of(rate.begin(), rate.end(), [](char c) { return c >= '0' && c <= '9'; });
  head.sample_rate_hz = is_number ? std::stoi(rate) : 0;
  if (head.sample_rate_hz < kLowestRate_hz || head.sample_rate_hz > kHighestRate_hz) {
    throw InputError(fmt::format("{}: metadata '{}'", where, kRate),
                     fmt::format("expected {} to {} Hz", kLowestRate_hz, kHighestRate_hz));
  }
  const Tensor& positions = checked(file, "positions_m", {0, 3}, where);
  const std::int64_t count = positions.shape[0];
  const Tensor& responses = checked(file, "responses", {count, 2, 0}, where);
  const Tensor& delays = checked(file, "delays_samples", {count, 2}, where);
  head.taps = static_cast<int>(responses.shape[2]);
  head.responses.assign(responses.as<float>().begin(), responses.as<float>().end());
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const std::span<const float> at = positions.as<float>().subspan(3 * i, 3);
    head.positions_m.push_back({at[0], at[1], at[2]});
    const std::span<const float> delay = delays.as<float>().subspan(2 * i, 2);
    head.delays_samples.push_back({delay[0], delay[1]});
  }
  return head;
}

}  // namespace earpoint
