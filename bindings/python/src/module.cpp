#include "bindings.h"

#include <string>

#include <pybind11/stl.h>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/network.h>
#include <earpoint/version.h>

namespace py = pybind11;

PYBIND11_MODULE(_earpoint, module) {
  module.doc() = "What the package earpoint is made of; use that.";
  py::register_exception<earpoint::InputError>(module, "InputError", PyExc_ValueError).doc() =
      "Bad data from outside: a file, a sound, a number. One line: where, what is wrong, what to "
      "do.";
  module.def("version", &earpoint::library_version);
  module.def("available_cores", &earpoint::available_cores);
  module.def("installed_networks", &earpoint::installed_networks);
  earpoint::python::bind_renderer(module);
  earpoint::python::bind_stream(module);
  earpoint::python::bind_trace(module);
  earpoint::python::bind_metrics(module);
  earpoint::python::bind_locate(module);
  earpoint::python::bind_simulate(module);
  earpoint::python::bind_weights(module);
  earpoint::python::bind_dataset(module);
}
