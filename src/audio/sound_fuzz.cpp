#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <fuzz_file.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/error.h>

/// Any bytes as a sound file: refused with InputError, or read in blocks of finite samples up to
/// the stated length.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  const FuzzFile file(data, size);
  try {
    SoundReader reader(file.path());
    std::int64_t samples = 0;
    for (int block = 0; block < 16; ++block) {
      const Waveform wave = reader.read(4096);
      if (wave.samples() == 0) break;
      samples += wave.samples();
      for (const float sample : wave.planar()) {
        if (!std::isfinite(sample)) std::abort();
      }
    }
    if (samples > reader.info().frames) std::abort();
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
