#include "failure.h"
#include "handles.h"

#include <earpoint/network.h>
#include <earpoint/pose.h>
#include <earpoint/version.h>

using earpoint::c_api::guarded;
using earpoint::c_api::not_null;

const char* earpoint_version(void) { return earpoint::library_version(); }

int earpoint_version_number(void) { return EARPOINT_VERSION_NUMBER; }

size_t earpoint_strings_count(const earpoint_strings* strings) {
  return strings == nullptr ? 0 : strings->texts.size();
}

const char* earpoint_strings_at(const earpoint_strings* strings, size_t index) {
  if (index >= earpoint_strings_count(strings)) return nullptr;
  return strings->texts[index].c_str();
}

void earpoint_strings_destroy(earpoint_strings* strings) { delete strings; }

earpoint_status earpoint_installed_models(earpoint_strings** models) {
  return guarded([&] {
    *not_null(models, "models") = nullptr;
    *models = new earpoint_strings{earpoint::installed_networks()};
  });
}

earpoint_status earpoint_describe_model(const char* model, int* renders, int* streams) {
  return guarded([&] {
    const earpoint::NetworkInfo info = earpoint::describe_network(not_null(model, "model"));
    if (renders != nullptr) *renders = info.renders ? 1 : 0;
    if (streams != nullptr) *streams = info.streams ? 1 : 0;
  });
}

earpoint_quaternion earpoint_quaternion_from_euler(double yaw_rad, double pitch_rad,
                                                   double roll_rad) {
  const earpoint::Quaternion q = earpoint::quaternion_from_euler({yaw_rad, pitch_rad, roll_rad});
  return {q.w, q.x, q.y, q.z};
}
