// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The channel table: every channel's name, type and, for the radio, treatment. Names stand here and nowhere
// else; the human-readable table with rates and sizes is lcmtypes/README.md.

#include <covey/band_t.hpp>
#include <covey/depth_t.hpp>
#include <covey/dpgo_advance_t.hpp>
#include <covey/dpgo_alignment_t.hpp>
#include <covey/dpgo_beacon_t.hpp>
#include <covey/dpgo_coarse_t.hpp>
#include <covey/dpgo_graph_t.hpp>
#include <covey/dpgo_join_t.hpp>
#include <covey/dpgo_keyframes_t.hpp>
#include <covey/dpgo_keys_t.hpp>
#include <covey/dpgo_neighbours_t.hpp>
#include <covey/dpgo_poses_t.hpp>
#include <covey/dpgo_relay_t.hpp>
#include <covey/dpgo_request_t.hpp>
#include <covey/dpgo_round_t.hpp>
#include <covey/imu_t.hpp>
#include <covey/keyframe_t.hpp>
#include <covey/lcd_bag_t.hpp>
#include <covey/lcd_frame_t.hpp>
#include <covey/lcd_inventory_t.hpp>
#include <covey/lcd_loop_t.hpp>
#include <covey/lcd_more_t.hpp>
#include <covey/lcd_request_t.hpp>
#include <covey/loop_t.hpp>
#include <covey/loop_weights_t.hpp>
#include <covey/mesh_block_t.hpp>
#include <covey/mesh_optimized_t.hpp>
#include <covey/odometry_t.hpp>
#include <covey/resend_t.hpp>
#include <covey/state_t.hpp>
#include <covey/status_t.hpp>
#include <covey/stereo_t.hpp>
#include <covey/stream_head_t.hpp>
#include <covey/trajectory_t.hpp>
#include <cstdint>
#include <string>
#include <tuple>

#include "core/radio/treatment.h"

namespace covey {

// A channel on one robot's bus.
template <typename T>
struct Channel {
  const char* name;
};

// A numbered stream: messages arrive once, in order and without gaps (within a stream), whatever the bus
// loses.
template <typename T>
struct StreamChannel {
  const char* name;
  std::int64_t (*stream)(const T&);
  std::int32_t (*number)(const T&);
};

// Messages too large for a datagram of the sensor buses: they travel as numbered bands (core/base/bands.h).
template <typename T>
struct BandedChannel {
  const char* name;
};

// The two names put together; lives as long as the process.
const char* radio_channel_name(const char* prefix, const char* name);

// A message between robots. Type T begins with utime, from, to.
template <typename T>
struct RadioChannel {
  const char* name;
  radio::Module module = radio::Module::kControl;  // who pays for the bytes
  // Repeated until every robot that it is meant for has it. Larger than a datagram (1.2 kB), it always is.
  bool reliable = false;
  int priority = 0;  // within the module, higher goes first
  // "OUT_" + name, written by the sending robot's process.
  Channel<T> out() const { return {radio_channel_name("OUT_", name)}; }
  // "IN_" + name, read by the receiving robot's process.
  Channel<T> in() const { return {radio_channel_name("IN_", name)}; }
};

// Sensor bus (IMU, STEREO, ODOMETRY) and depth bus (DEPTH).
inline constexpr Channel<imu_t> kImu{"IMU"};
inline constexpr BandedChannel<stereo_t> kStereo{"STEREO"};
inline constexpr BandedChannel<depth_t> kDepth{"DEPTH"};
inline constexpr Channel<odometry_t> kOdometry{"ODOMETRY"};

// Robot's private bus.
inline constexpr Channel<status_t> kStatus{"STATUS"};
inline constexpr Channel<resend_t> kResend{"RESEND"};
inline constexpr Channel<stream_head_t> kStreamHead{"STREAM_HEAD"};
inline constexpr Channel<state_t> kState{"STATE"};
inline constexpr Channel<mesh_optimized_t> kMeshOptimized{"MESH_OPTIMIZED"};
inline constexpr Channel<trajectory_t> kTrajectory{"TRAJECTORY"};
inline constexpr Channel<loop_weights_t> kLoopWeights{"LOOP_WEIGHTS"};

inline constexpr StreamChannel<keyframe_t> kKeyframe{
    "KEYFRAME", [](const keyframe_t& keyframe) { return keyframe.segment; },
    [](const keyframe_t& keyframe) { return keyframe.id; }};
inline constexpr StreamChannel<loop_t> kLoop{"LOOP", [](const loop_t& loop) { return loop.stream; },
                                             [](const loop_t& loop) { return loop.number; }};
inline constexpr StreamChannel<mesh_block_t> kMesh{"MESH",
                                                   [](const mesh_block_t& block) { return block.stream; },
                                                   [](const mesh_block_t& block) { return block.number; }};

// Presence goes before the work: a beacon that waits behind updates makes a robot look absent.
inline constexpr RadioChannel<dpgo_beacon_t> kDpgoBeacon{"DPGO_BEACON", radio::Module::kDpgo, false, 2};
inline constexpr RadioChannel<dpgo_neighbours_t> kDpgoNeighbours{"DPGO_NEIGHBOURS", radio::Module::kDpgo,
                                                                 false, 2};
inline constexpr RadioChannel<dpgo_round_t> kDpgoRound{"DPGO_ROUND", radio::Module::kDpgo, false, 2};
inline constexpr RadioChannel<dpgo_request_t> kDpgoRequest{"DPGO_REQUEST", radio::Module::kDpgo, false, 1};
inline constexpr RadioChannel<dpgo_join_t> kDpgoJoin{"DPGO_JOIN", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_keys_t> kDpgoKeys{"DPGO_KEYS", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_keyframes_t> kDpgoStart{"DPGO_START", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_alignment_t> kDpgoAlignment{"DPGO_ALIGNMENT", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_advance_t> kDpgoAdvance{"DPGO_ADVANCE", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_coarse_t> kDpgoCoarse{"DPGO_COARSE", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_graph_t> kDpgoGraph{"DPGO_GRAPH", radio::Module::kDpgo, true};
inline constexpr RadioChannel<dpgo_poses_t> kDpgoPoses{"DPGO_POSES", radio::Module::kDpgo, true};
// Passed on: as the message itself would travel.
inline constexpr RadioChannel<dpgo_relay_t> kDpgoRelay{"DPGO_RELAY", radio::Module::kDpgo, false, 2};
inline constexpr RadioChannel<dpgo_relay_t> kDpgoRelayRound{"DPGO_RELAY_ROUND", radio::Module::kDpgo, true};

// What an inventory does not list is sent again: bags need no acknowledgement of their own.
inline constexpr RadioChannel<lcd_inventory_t> kLcdInventory{"LCD_INVENTORY",
                                                             radio::Module::kPlaceRecognition, false, 2};
inline constexpr RadioChannel<lcd_bag_t> kLcdBag{"LCD_BAG", radio::Module::kPlaceRecognition, false};
inline constexpr RadioChannel<lcd_request_t> kLcdRequest{"LCD_REQUEST", radio::Module::kGeometricVerification,
                                                         true, 1};
inline constexpr RadioChannel<lcd_more_t> kLcdMore{"LCD_MORE", radio::Module::kGeometricVerification, true,
                                                   1};
inline constexpr RadioChannel<lcd_frame_t> kLcdFrame{"LCD_FRAME", radio::Module::kGeometricVerification,
                                                     true};
inline constexpr RadioChannel<lcd_loop_t> kLcdLoop{"LCD_LOOP", radio::Module::kGeometricVerification, true,
                                                   1};

// Every radio channel. radio_bridge lets nothing else cross.
inline constexpr std::tuple kRadioChannels{
    kDpgoBeacon,    kDpgoNeighbours, kDpgoRound,  kDpgoRequest, kDpgoJoin,  kDpgoKeys,  kDpgoStart,
    kDpgoAlignment, kDpgoAdvance,    kDpgoCoarse, kDpgoGraph,   kDpgoPoses, kDpgoRelay, kDpgoRelayRound,
    kLcdInventory,  kLcdBag,         kLcdRequest, kLcdMore,     kLcdFrame,  kLcdLoop};

// The same without the types.
const radio::TreatmentTable& radio_table();

}  // namespace covey
