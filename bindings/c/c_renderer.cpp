#include "convert.h"
#include "failure.h"
#include "handles.h"

#include <algorithm>

#include <earpoint/renderer.h>

using earpoint::c_api::guarded;
using earpoint::c_api::not_null;

earpoint_status earpoint_renderer_open(const char* model, const earpoint_renderer_options* options,
                                       earpoint_renderer** renderer) {
  return guarded([&] {
    *not_null(renderer, "renderer") = nullptr;
    *renderer = new earpoint_renderer{earpoint::Renderer::open(
        model == nullptr ? "gtf" : model, earpoint::c_api::renderer_options_from(options))};
  });
}

void earpoint_renderer_close(earpoint_renderer* renderer) { delete renderer; }

const char* earpoint_renderer_model(const earpoint_renderer* renderer) {
  return renderer == nullptr ? nullptr : renderer->renderer.model().c_str();
}

earpoint_status earpoint_renderer_render(earpoint_renderer* renderer, const earpoint_sound* sound,
                                         const earpoint_request* request, float* const* out) {
  return guarded([&] {
    not_null(renderer, "renderer");
    not_null(out, "out");
    for (int ear = 0; ear < 2; ++ear) not_null(out[ear], "an ear of out");
    const earpoint::c_api::Request asked(request);
    const earpoint::Waveform there = renderer->renderer.render(
        earpoint::c_api::waveform_from(*not_null(sound, "sound")), asked.contents);
    for (int ear = 0; ear < 2; ++ear) std::ranges::copy(there.channel(ear), out[ear]);
  });
}

earpoint_status earpoint_renderer_warnings(const earpoint_renderer* renderer,
                                           const earpoint_sound* sound,
                                           const earpoint_request* request,
                                           earpoint_strings** warnings) {
  return guarded([&] {
    *not_null(warnings, "warnings") = nullptr;
    not_null(renderer, "renderer");
    const earpoint::c_api::Request asked(request);
    *warnings = new earpoint_strings{renderer->renderer.warnings(
        earpoint::c_api::waveform_from(*not_null(sound, "sound")), asked.contents)};
  });
}
