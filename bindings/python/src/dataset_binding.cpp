#include "arrays.h"
#include "bindings.h"
#include "pair_reader.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

py::array_t<double> numbers_of(std::vector<double> values) {
  const auto count = static_cast<py::ssize_t>(values.size());
  return array_of(std::move(values), {count});
}

/// The picture as the file has it, or as a network is shown it.
py::array picture_of(const PairItem& item) {
  if (!item.view) return channels_first(*item.sample.picture);
  return array_of(item.view->values, {3, item.view->height, item.view->width});
}

py::dict dict_of(const PairItem& item) {
  const PairSample& sample = item.sample;
  py::dict result;
  result["src_wav"] = array_of(sample.source);
  result["tgt_wav"] = array_of(sample.target);
  result["src_rgb"] = picture_of(item);
  result["tgt_pose"] =
      array_of(item.pose.tgt_pose, {static_cast<py::ssize_t>(item.pose.tgt_pose.size())});
  result["tgt_rotation"] =
      array_of(item.pose.tgt_rotation, {static_cast<py::ssize_t>(item.pose.tgt_rotation.size())});
  result["bboxes"] = array_of(item.box, {4});
  const Pose& pose = sample.source_from_target;
  result["position"] = numbers_of({pose.position_m.x, pose.position_m.y, pose.position_m.z});
  const Quaternion& q = pose.orientation;
  result["orientation"] = numbers_of({q.w, q.x, q.y, q.z});
  result["name"] = item.name;
  return result;
}

}  // namespace

void bind_dataset(py::module_& module) {
  py::class_<PairReader>(module, "PairReader")
      .def(py::init([](const std::string& folder, const std::string& split,
                       const std::optional<std::string>& layout, const std::string& draw,
                       std::uint64_t seed, const std::optional<std::string>& network, bool align) {
        const PairOptions options{split, layout, draw, seed, network, align};
        return without_lock([&] { return std::make_unique<PairReader>(folder, options); });
      }))
      .def("__len__", &PairReader::size)
      .def("layout", &PairReader::layout)
      .def("item",
           [](const PairReader& reader, std::size_t index) {
             return dict_of(without_lock([&] { return reader.item(index); }));
           })
      .def("drawn", [](const PairReader& reader, std::size_t index, std::uint64_t seed) {
        return dict_of(without_lock([&] { return reader.drawn(index, seed); }));
      });
}

}  // namespace earpoint::python
