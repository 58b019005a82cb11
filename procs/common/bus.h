// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A typed LCM bus for nodes that do not want to know liblcm. What it takes care of:
//  - handlers run from the event loop, never inside liblcm; an exception there is counted ("bugs/CHANNEL");
//  - liblcm only enqueues: its own queues are unlimited (they would drop the newest), ours are bounded where
//    QueueOptions says so;
//  - what cannot be decoded is dropped and counted ("dropped/CHANNEL/undecodable"); "in/CHANNEL" counts what
//    handlers saw, "out/CHANNEL" what was published;
//  - channel names are escaped (liblcm subscribes to regular expressions) and held to its limit of 63 bytes;
//  - udpm URLs get a receive buffer of 4 MiB and ttl 0 unless they say otherwise; a bus that cannot be opened
//    is an InputError;
//  - image sets travel in bands (core/base/bands.h), paced as they are sent, put together before a node sees them;
//  - numbered streams are repaired inside (core/base/stream.h): RESEND and STREAM_HEAD never reach a node;
//  - a URL file://F.lcm reads a log in the loop's virtual time, and publishes into the recording only.
// On a live bus a process hears what it publishes itself, if it subscribes to it; from a log it hears what
// the log has. Nothing unsubscribes.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/bytes.h"
#include "core/base/stream.h"
#include "procs/common/bus_faults.h"
#include "procs/common/channels.h"
#include "procs/common/event_loop.h"
#include "procs/common/status.h"

namespace covey {

struct QueueOptions {
  bool newest_wins =
      false;  // a full queue drops its oldest message (else the newest), counted "dropped/CHANNEL/queue_full"
  std::size_t capacity = 0;  // messages; 0: unlimited, or 1 with newest_wins
};

class LogRecorder;

struct BusOptions {
  std::string url;
  BusFaults faults;
  std::shared_ptr<LogRecorder> recorder;  // takes a copy of what is published; may be empty
};

class Bus {
 public:
  Bus(const BusOptions& options, EventLoop& loop, Status& status);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  template <typename T>
  using MessageHandler = std::type_identity_t<std::function<void(const T&)>>;
  using RawHandler = std::function<void(const std::string& channel, const Bytes& bytes)>;

  template <typename T>
  void subscribe(const Channel<T>& channel, MessageHandler<T> handler, QueueOptions queue = {});
  template <typename T>
  void publish(const Channel<T>& channel, const T& message);

  // Once, in order, without gaps within a stream. `have`: what this process read back from disk and need not
  // hear again.
  template <typename T>
  void subscribe(const StreamChannel<T>& channel, MessageHandler<T> handler,
                 const StreamPositions& have = {});
  // Kept in memory (64 MiB a channel) and sent again when asked for. The number must follow the last one of
  // its stream.
  template <typename T>
  void publish(const StreamChannel<T>& channel, const T& message);

  // IN_x and OUT_x.
  template <typename T>
  void subscribe(const RadioChannel<T>& channel, MessageHandler<T> handler, QueueOptions queue = {});
  template <typename T>
  void publish(const RadioChannel<T>& channel, const T& message);

  // Complete messages only; bands that cannot be used are counted ("dropped/STEREO/old", ...), and so are image sets that
  // lost some or all of their bands ("lost/STEREO"). In a log the bands are what is recorded.
  template <typename T>
  void subscribe(const BandedChannel<T>& channel, MessageHandler<T> handler,
                 QueueOptions queue = {.newest_wins = true});
  template <typename T>
  void publish(const BandedChannel<T>& channel, const T& message);

  // Bytes as they come, for every channel that matches the regular expression as a whole.
  void subscribe_raw(const std::string& regex, RawHandler handler, QueueOptions queue = {});
  // False, and counted, where liblcm cannot send it (name too long).
  bool publish_raw(const std::string& channel, const Bytes& bytes);

  const std::string& url() const;  // as opened
  bool from_log() const;

 private:
  struct Impl;
  using BytesHandler = std::function<bool(const Bytes&)>;  // false: undecodable
  using NumberOf = std::function<bool(const Bytes&, StreamMessage&)>;

  template <typename T>
  static BytesHandler decoded(MessageHandler<T> handler);
  void subscribe_bytes(const std::string& channel, BytesHandler handler, QueueOptions queue);
  void subscribe_stream(const std::string& channel, NumberOf number_of, BytesHandler handler,
                        const StreamPositions& have);
  void publish_stream(const std::string& channel, const StreamMessage& message);
  void subscribe_bands(const std::string& channel, BytesHandler handler, QueueOptions queue);
  void publish_bands(const std::string& channel, Utime utime, const Bytes& bytes);

  std::unique_ptr<Impl> impl_;
};

constexpr int kLastRobot = 19;  // ports 7700+r, 7720+r and 7740+r stay apart
// The URL of a robot's private bus.
std::string robot_bus_url(int robot);
// Of its IMU and stereo images, and of its depth images: only who needs them opens them.
std::string sensor_bus_url(int robot);
std::string depth_bus_url(int robot);
// file://F.lcm
bool is_log_url(const std::string& url);

template <typename T>
Bus::BytesHandler Bus::decoded(MessageHandler<T> handler) {
  return [handler = std::move(handler)](const Bytes& bytes) {
    T message{};
    if (!decode(bytes, message)) return false;
    handler(message);
    return true;
  };
}

template <typename T>
void Bus::subscribe(const Channel<T>& channel, MessageHandler<T> handler, QueueOptions queue) {
  subscribe_bytes(channel.name, decoded<T>(std::move(handler)), queue);
}

template <typename T>
void Bus::publish(const Channel<T>& channel, const T& message) {
  publish_raw(channel.name, encode(message));
}

template <typename T>
void Bus::subscribe(const StreamChannel<T>& channel, MessageHandler<T> handler, const StreamPositions& have) {
  subscribe_stream(
      channel.name,
      [channel](const Bytes& bytes, StreamMessage& numbered) {
        T message{};
        if (!decode(bytes, message)) return false;
        numbered.stream = channel.stream(message);
        numbered.number = channel.number(message);
        return true;
      },
      decoded<T>(std::move(handler)), have);
}

template <typename T>
void Bus::publish(const StreamChannel<T>& channel, const T& message) {
  publish_stream(channel.name, {channel.stream(message), channel.number(message), encode(message)});
}

template <typename T>
void Bus::subscribe(const BandedChannel<T>& channel, MessageHandler<T> handler, QueueOptions queue) {
  subscribe_bands(channel.name, decoded<T>(std::move(handler)), queue);
}

template <typename T>
void Bus::publish(const BandedChannel<T>& channel, const T& message) {
  publish_bands(channel.name, message.utime, encode(message));
}

template <typename T>
void Bus::subscribe(const RadioChannel<T>& channel, MessageHandler<T> handler, QueueOptions queue) {
  subscribe(channel.in(), std::move(handler), queue);
}

template <typename T>
void Bus::publish(const RadioChannel<T>& channel, const T& message) {
  publish(channel.out(), message);
}

}  // namespace covey
