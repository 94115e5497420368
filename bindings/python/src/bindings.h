#pragma once

#include <pybind11/pybind11.h>

namespace earpoint::python {

/// Each adds its part to the module `earpoint._earpoint`, which the package's Python files wrap:
/// they hold names, defaults and documentation, these convert and call.
void bind_renderer(pybind11::module_& module);
void bind_stream(pybind11::module_& module);
void bind_trace(pybind11::module_& module);
void bind_metrics(pybind11::module_& module);
void bind_locate(pybind11::module_& module);
void bind_simulate(pybind11::module_& module);
void bind_weights(pybind11::module_& module);
void bind_dataset(pybind11::module_& module);

/// Runs long work without Python's global lock, so that other threads go on.
template <typename Work>
auto without_lock(Work&& work) {
  const pybind11::gil_scoped_release release;
  return work();
}

}  // namespace earpoint::python
