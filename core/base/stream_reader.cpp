// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/stream.h"

namespace covey {

StreamReader::StreamReader(StreamReaderOptions options, const StreamPositions& have) : options_(options) {
  for (const auto& [name, next] : have) {
    streams_[name].expected = next;
    streams_[name].known = next;
  }
}

StreamActions StreamReader::on_message(StreamMessage message, Utime now) {
  StreamActions actions;
  Stream* stream = find(message.stream);
  if (stream == nullptr) return actions;
  stream->unheard = 0;
  if (message.number < 0 || message.number - stream->expected > options_.furthest) {
    ++counts_.impossible;
    return actions;
  }
  if (message.number < stream->expected || stream->waiting.count(message.number) > 0) {
    ++counts_.duplicate;
    return actions;
  }
  const bool was_missing = message.number < stream->known;
  stream->known = std::max(stream->known, message.number + 1);
  if (wait(*stream, message.number, std::move(message.bytes))) {
    hand_on(message.stream, *stream, actions);
    if (was_missing) note_progress(*stream, now);
  }
  update_gap(*stream, now);
  return actions;
}

StreamActions StreamReader::on_head(const StreamHead& head, Utime now) {
  StreamActions actions;
  Stream* stream = find(head.stream);
  if (stream == nullptr) return actions;
  stream->unheard = 0;
  if (head.first < 0 || head.next < head.first || head.next - stream->expected > options_.furthest) {
    ++counts_.impossible;
    return actions;
  }
  stream->head_first = head.first;
  stream->head_next = head.next;
  stream->known = std::max(stream->known, head.next);
  if (head.first > stream->expected) jump(head.stream, *stream, head.first, actions);
  update_gap(*stream, now);
  return actions;
}

StreamActions StreamReader::on_tick(Utime now) {
  StreamActions actions;
  for (auto& [name, stream] : streams_) {
    if (!stream.behind || now < stream.request_us) continue;
    if (stream.unheard >= options_.give_up_silent_after) {
      leave(name, stream, actions);
      continue;
    }
    const bool writer_has_it = stream.head_first <= stream.expected && stream.expected < stream.head_next;
    if (writer_has_it && stream.unanswered >= options_.give_up_after && !stream.waiting.empty()) {
      jump(name, stream, stream.waiting.begin()->first, actions);
      note_progress(stream, now);
      update_gap(stream, now);
      continue;
    }
    request(name, stream, actions);
    stream.request_us = now + stream.backoff_us;
    stream.backoff_us = std::min(2 * stream.backoff_us, options_.longest_backoff_us);
    if (writer_has_it) ++stream.unanswered;
    ++stream.unheard;
  }
  return actions;
}

std::size_t StreamReader::waiting() const {
  std::size_t messages = 0;
  for (const auto& [name, stream] : streams_) messages += stream.waiting.size();
  return messages;
}

StreamReader::Stream* StreamReader::find(std::int64_t name) {
  const auto found = streams_.find(name);
  if (found != streams_.end()) return &found->second;
  if (streams_.size() >= options_.max_streams) {
    ++counts_.refused;
    return nullptr;
  }
  return &streams_[name];
}

// Room is made by letting go of what lies furthest ahead in the same stream: it will be asked for when its
// turn comes.
bool StreamReader::wait(Stream& stream, std::int32_t number, Bytes bytes) {
  const bool next_in_turn = number == stream.expected;
  while (!next_in_turn && waiting_bytes_ + bytes.size() > options_.waiting_bytes) {
    ++counts_.refused;
    if (stream.waiting.empty() || stream.waiting.rbegin()->first < number) return false;
    const auto furthest = std::prev(stream.waiting.end());
    waiting_bytes_ -= furthest->second.size();
    stream.waiting.erase(furthest);
  }
  waiting_bytes_ += bytes.size();
  stream.waiting.emplace(number, std::move(bytes));
  return true;
}

void StreamReader::hand_on(std::int64_t name, Stream& stream, StreamActions& actions) {
  auto next = stream.waiting.begin();
  while (next != stream.waiting.end() && next->first == stream.expected) {
    waiting_bytes_ -= next->second.size();
    actions.deliver.push_back({name, stream.expected, std::move(next->second)});
    ++stream.expected;
    next = stream.waiting.erase(next);
  }
}

// Over what is lost for good; what waits before `to` is still handed on.
void StreamReader::jump(std::int64_t name, Stream& stream, std::int32_t to, StreamActions& actions) {
  while (stream.expected < to) {
    const auto next = stream.waiting.begin();
    const std::int32_t found = next == stream.waiting.end() ? to : std::min(to, next->first);
    counts_.lost += found - stream.expected;
    stream.expected = found;
    hand_on(name, stream, actions);
  }
  stream.known = std::max(stream.known, stream.expected);
}

// The writer is gone for good. A tail that never came, behind which nothing waits, is not jumped over: should the
// writer come again, it is asked for.
void StreamReader::leave(std::int64_t name, Stream& stream, StreamActions& actions) {
  if (!stream.waiting.empty()) jump(name, stream, stream.waiting.rbegin()->first + 1, actions);
  stream.known = stream.expected;
  stream.behind = false;
}

void StreamReader::note_progress(Stream& stream, Utime now) {
  stream.unanswered = 0;
  stream.backoff_us = options_.first_backoff_us;
  const bool all_came = stream.expected >= stream.asked_until;  // then the next span is asked for at once
  stream.request_us =
      all_came ? now
               : std::clamp(stream.request_us, now + options_.reorder_us, now + options_.first_backoff_us);
}

void StreamReader::update_gap(Stream& stream, Utime now) {
  const bool behind = stream.expected < stream.known;
  if (behind && !stream.behind) {
    stream.request_us = now + options_.reorder_us;
    stream.backoff_us = options_.first_backoff_us;
    stream.unanswered = 0;
  }
  stream.behind = behind;
}

void StreamReader::request(std::int64_t name, Stream& stream, StreamActions& actions) {
  const std::int32_t end = std::min(stream.known, stream.expected + options_.span);
  std::int32_t first = stream.expected;
  auto next = stream.waiting.begin();
  for (std::size_t range = 0; range < options_.ranges && first < end; ++range) {
    const std::int32_t last = next == stream.waiting.end() ? end - 1 : std::min(end, next->first) - 1;
    actions.resend.push_back({name, first, last});
    ++counts_.requests;
    first = last + 1;
    while (next != stream.waiting.end() && next->first == first) {
      ++first;
      ++next;
    }
  }
  stream.asked_until = first;
}

}  // namespace covey
