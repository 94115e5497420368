#pragma once

#include <variant>

#include <earpoint/render/dsp_stream.h>
#include <earpoint/render/render_stream.h>
#include <earpoint/stream.h>

namespace earpoint {

struct Stream::State {
  std::variant<RenderStream, DspStream> stream;
};

}  // namespace earpoint
