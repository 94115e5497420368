#include "arrays.h"
#include "bindings.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/gtf/weights.h>
#include <earpoint/network.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/people/weights.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

/// NumPy's name of an element type. @return nothing for bfloat16, which NumPy lacks
std::optional<std::string> numpy_name(DType type) {
  static const std::map<DType, std::string> names = {
      {DType::f64, "<f8"}, {DType::f32, "<f4"}, {DType::f16, "<f2"}, {DType::i64, "<i8"},
      {DType::i32, "<i4"}, {DType::i16, "<i2"}, {DType::i8, "|i1"},  {DType::u64, "<u8"},
      {DType::u32, "<u4"}, {DType::u16, "<u2"}, {DType::u8, "|u1"},  {DType::boolean, "|b1"}};
  const auto found = names.find(type);
  return found == names.end() ? std::nullopt : std::optional(found->second);
}

/// The array takes the tensor's memory.
py::array array_of_tensor(Tensor tensor) {
  if (tensor.dtype == DType::bf16) tensor = to_float32(tensor);
  auto* kept = new Tensor(std::move(tensor));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Tensor*>(memory); });
  const std::vector<py::ssize_t> shape(kept->shape.begin(), kept->shape.end());
  return {py::dtype(*numpy_name(kept->dtype)), shape, kept->data.data(), owner};
}

Tensor tensor_of(const std::string& name, const py::array& given) {
  const py::array array = py::array::ensure(given, py::array::c_style);
  for (const DType type :
       {DType::f64, DType::f32, DType::f16, DType::i64, DType::i32, DType::i16, DType::i8,
        DType::u64, DType::u32, DType::u16, DType::u8, DType::boolean}) {
    if (!array.dtype().equal(py::dtype(*numpy_name(type)))) continue;
    Tensor tensor{type, {array.shape(), array.shape() + array.ndim()}, {}};
    tensor.data.resize(static_cast<std::size_t>(array.nbytes()));
    if (!tensor.data.empty()) std::memcpy(tensor.data.data(), array.data(), tensor.data.size());
    return tensor;
  }
  throw py::value_error(fmt::format("{}: a weight file has no type for {}", name,
                                    py::str(array.dtype()).cast<std::string>()));
}

/// @return tensors by name, the file's metadata, its path, the kind of network
py::tuple load(const std::string& model) {
  auto [file, info] = without_lock([&] {
    NetworkInfo described = describe_network(model);
    return std::pair{read_safetensors(described.file), std::move(described)};
  });
  py::dict tensors;
  for (auto& [name, tensor] : file.tensors)
    tensors[py::str(name)] = array_of_tensor(std::move(tensor));
  return py::make_tuple(tensors, file.metadata, info.file.string(), info.kind);
}

/// Refuses what the engine could not load.
void check_weights(SafetensorsFile file, const std::string& where) {
  switch (network_kind(file, where)) {
    case NetworkKind::vigas:
      (void)vigas_weights(std::move(file), where);
      return;
    case NetworkKind::gtf:
      (void)gtf_weights(std::move(file), where);
      return;
    case NetworkKind::rt60_estimator:
      (void)rt60_estimator_weights(std::move(file), where);
      return;
    case NetworkKind::vam:
      (void)vam_weights(std::move(file), where);
      return;
    case NetworkKind::people:
      (void)people_weights(std::move(file), where);
      return;
  }
}

void save(const std::string& path, const std::map<std::string, py::array>& tensors,
          const std::map<std::string, std::string>& metadata) {
  SafetensorsFile file;
  for (const auto& [name, array] : tensors) file.tensors.emplace(name, tensor_of(name, array));
  file.metadata = metadata;
  without_lock([&] {
    check_weights(file, path);
    write_safetensors(path, file);
  });
}

}  // namespace

void bind_weights(py::module_& module) {
  module.def("load_weights", &load);
  module.def("save_weights", &save);
}

}  // namespace earpoint::python
