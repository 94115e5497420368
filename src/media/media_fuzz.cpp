#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>

#include <fuzz_file.h>

#include <earpoint/error.h>
#include <earpoint/media/media.h>

namespace {

/// Whatever the reader does, it throws nothing but InputError.
void attempt(const std::function<void()>& read) {
  try {
    read();
  } catch (const earpoint::InputError&) {
    return;
  }
}

}  // namespace

/// Any bytes as a movie, a sound or a picture: refused with InputError, or probed and its beginning
/// read, as sound and as pictures of the size that was stated.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  const FuzzFile file(data, size);
  attempt([&] { (void)probe_media(file.path()); });
  attempt([&] {
    AudioReader reader(file.path(), std::array{0, 1});
    for (int block = 0; block < 8; ++block) {
      if (reader.read(4096).samples() == 0) break;
    }
  });
  attempt([&] {
    FrameReader reader(file.path());
    for (const double time_s : {0.0, 0.1, 3.0, 0.05}) {
      if (reader.frame_nearest(time_s).empty() || !std::isfinite(reader.frame_time_s()))
        std::abort();
    }
  });
  return 0;
}
