#pragma once

#include <earpoint/render/render_stream.h>
#include <earpoint/stream.h>

namespace earpoint {

struct Stream::State {
  RenderStream stream;
};

}  // namespace earpoint
