// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The numbered streams of one bus: the state machines of core/base/stream.h, one reader for each subscription
// and one writer for each channel, translated to RESEND and STREAM_HEAD and counted in STATUS.

#include <covey/resend_t.hpp>
#include <covey/stream_head_t.hpp>
#include <deque>
#include <functional>
#include <map>
#include <string>

#include "core/base/stream.h"
#include "procs/common/status.h"

namespace covey {

class BusStreams {
 public:
  using Publish = std::function<void(const std::string& channel, const Bytes& bytes)>;
  using Deliver = std::function<void(const Bytes& bytes)>;

  struct Reader {
    std::string channel;
    StreamReader machine;
    Deliver deliver;
    StreamReaderCounts reported;
  };

  BusStreams(const StreamReaderOptions& options, Status& status, Publish publish)
      : options_(options), status_(status), publish_(std::move(publish)) {}

  Reader& add_reader(const std::string& channel, const StreamPositions& have,
                     Deliver deliver);  // stays where it is
  void on_message(Reader& reader, StreamMessage message, Utime now);
  void on_head(const stream_head_t& head, Utime now);

  void on_publish(const std::string& channel, const StreamMessage& message);
  void on_resend(const resend_t& resend);

  void on_tick(Utime now);

 private:
  struct Writer {
    StreamWriter machine;
    StreamWriterCounts reported;
  };

  void act(Reader& reader, const StreamActions& actions, Utime now);
  void act(const std::string& channel, const StreamWriterActions& actions, Utime now);
  void report(Reader& reader);
  void report(const std::string& channel, Writer& writer);
  void count_new(const std::string& name, std::int64_t total, std::int64_t& reported);

  StreamReaderOptions options_;
  Status& status_;
  Publish publish_;
  std::deque<Reader> readers_;
  std::map<std::string, Writer> writers_;
};

}  // namespace covey
