// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/bus_streams.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "procs/common/channels.h"

namespace covey {

BusStreams::Reader& BusStreams::add_reader(const std::string& channel, const StreamPositions& have,
                                           Deliver deliver) {
  readers_.push_back({channel, StreamReader(options_, have), std::move(deliver), {}});
  return readers_.back();
}

void BusStreams::on_message(Reader& reader, StreamMessage message, Utime now) {
  act(reader, reader.machine.on_message(std::move(message), now), now);
}

void BusStreams::on_head(const stream_head_t& head, Utime now) {
  for (std::size_t i = 0; i < readers_.size(); ++i) {  // a handler may add a reader
    Reader& reader = readers_[i];
    if (reader.channel != head.channel) continue;
    act(reader, reader.machine.on_head({head.stream, head.first, head.next}, now), now);
  }
}

void BusStreams::on_publish(const std::string& channel, const StreamMessage& message) {
  if (writers_[channel].machine.on_publish(message)) return;
  spdlog::error("{}: number {} of stream {} does not follow the last one; it is sent but cannot be repaired",
                channel, message.number, message.stream);
}

void BusStreams::on_resend(const resend_t& resend) {
  const auto writer = writers_.find(resend.channel);
  if (writer != writers_.end()) writer->second.machine.on_resend({resend.stream, resend.first, resend.last});
}

void BusStreams::on_tick(Utime now) {
  for (std::size_t i = 0; i < readers_.size(); ++i) act(readers_[i], readers_[i].machine.on_tick(now), now);
  for (auto& [channel, writer] : writers_) {
    act(channel, writer.machine.on_tick(now), now);
    report(channel, writer);
  }
}

void BusStreams::act(Reader& reader, const StreamActions& actions, Utime now) {
  for (const StreamMessage& message : actions.deliver) reader.deliver(message.bytes);
  for (const StreamGap& gap : actions.resend) {
    resend_t message{};
    message.utime = now;
    message.channel = reader.channel;
    message.stream = gap.stream;
    message.first = gap.first;
    message.last = gap.last;
    publish_(kResend.name, encode(message));
  }
  report(reader);
}

void BusStreams::act(const std::string& channel, const StreamWriterActions& actions, Utime now) {
  for (const StreamMessage& message : actions.send) publish_(channel, message.bytes);
  for (const StreamHead& head : actions.heads) {
    stream_head_t message{};
    message.utime = now;
    message.channel = channel;
    message.stream = head.stream;
    message.first = head.first;
    message.next = head.next;
    publish_(kStreamHead.name, encode(message));
  }
}

void BusStreams::report(Reader& reader) {
  const StreamReaderCounts& now = reader.machine.counts();
  StreamReaderCounts& reported = reader.reported;
  count_new("dropped/" + reader.channel + "/duplicate", now.duplicate, reported.duplicate);
  count_new("dropped/" + reader.channel + "/impossible", now.impossible, reported.impossible);
  count_new("dropped/" + reader.channel + "/no_room", now.refused, reported.refused);
  count_new("lost/" + reader.channel, now.lost, reported.lost);
  count_new("requests/" + reader.channel, now.requests, reported.requests);
}

void BusStreams::report(const std::string& channel, Writer& writer) {
  const StreamWriterCounts& now = writer.machine.counts();
  StreamWriterCounts& reported = writer.reported;
  count_new("bugs/" + channel + "/out_of_order", now.out_of_order, reported.out_of_order);
  count_new("resent/" + channel, now.resent, reported.resent);
  count_new("forgotten/" + channel, now.forgotten, reported.forgotten);
}

void BusStreams::count_new(const std::string& name, std::int64_t total, std::int64_t& reported) {
  if (total != reported) status_.count(name, total - std::exchange(reported, total));
}

}  // namespace covey
