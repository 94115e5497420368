#pragma once

#include <earpoint/waveform.h>

namespace earpoint {

/// Where rendered sound goes: blocks of 2 channels.
class SoundSink {
 public:
  virtual ~SoundSink() = default;
  virtual void write(const Waveform& block) = 0;
  /// Makes the file whole and lets it appear under its name; without it nothing is left.
  virtual void commit() = 0;
  [[nodiscard]] virtual int sample_rate_hz() const = 0;
};

}  // namespace earpoint
