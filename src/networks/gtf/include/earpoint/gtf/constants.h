#pragma once

/// Numbers of the network's layers that no weight file holds. The engine and the training graph are
/// two implementations of one network, held against each other by tests; both read these. Frames
/// are at the level that kHeardLevel brings every sound to.
namespace earpoint::gtf {

// The sound as a whole.
inline constexpr float kHeardLevel = 0.05F;  ///< root mean square that every sound is brought to
inline constexpr float kQuietest = 1e-4F;    ///< root mean square below which a sound is silence

// Short-time spectra. Floors are added before a root, a logarithm or a division.
inline constexpr float kPowerFloor = 1e-8F;     ///< to a bin's power
inline constexpr float kBandFloor = 1e-3F;      ///< to a band's power
inline constexpr float kCrossFloor = 1e-4F;     ///< to the product of the ears' powers in a band
inline constexpr float kBalanceFloor = 1e-4F;   ///< to the ears' mean powers that are compared
inline constexpr float kStrengthFloor = 1e-6F;  ///< to a sum that weighs frames
inline constexpr float kBandLogScale = 4.0F;    ///< what logarithms of bands' powers are divided by
inline constexpr float kLagScale = 40.0F;       ///< what correlations over lags are divided by

// The filter of magnitudes.
inline constexpr float kMagnitudeFloor = 1e-3F;  ///< is added before the gain
inline constexpr float kLeastLogGain = -3.0F;
inline constexpr float kMostLogGain = 2.0F;
inline constexpr float kLeastDryLogGain = -5.0F;  ///< of the dry voice
inline constexpr float kMostDryLogGain = 4.0F;

// The picture, and the box in it.
inline constexpr float kMiddleGrey = 0.5F;     ///< is subtracted from pixels of 0 to 1
inline constexpr double kLowestEdge = 0.99;    ///< a box that ends below is cut off by the picture
inline constexpr double kBoxSizeFloor = 0.02;  ///< is added to width and height in logarithms
inline constexpr double kTrustInBox = 3.0;     ///< weight of the box's direction

// The speaker's place, from the locator's outputs.
inline constexpr int kLocatorOutputs = 9;       ///< direction 2, distance, height, heading 2,
                                                ///< level of reverberation, 2 that are not read
inline constexpr double kLogDistance = 0.6;     ///< logarithm of metres at an output of 0
inline constexpr double kLeastLogRatio = -2.0;  ///< of the distance to that
inline constexpr double kMostLogRatio = 1.5;
inline constexpr double kHeightScale_m = 0.3;
inline constexpr double kUsualHeight_m = -0.1;  ///< of the mouth, at an output of 0

// What geometry tells.
inline constexpr double kPositionScale_m = 3.0;     ///< what positions are divided by
inline constexpr double kReverberationScale = 3.0;  ///< what its logarithm is divided by
// Squares that are added below roots, so that slopes are finite at zero.
inline constexpr double kDirectionFloor = 1e-4;  ///< to the length of a direction in the plane
inline constexpr double kDistanceFloor = 1e-2;   ///< to a distance, m^2

/// Taps of the trunk's convolutions.
inline constexpr int kTrunkTaps = 3;

}  // namespace earpoint::gtf
