// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/stream.h"

namespace covey {

StreamWriter::StreamWriter(StreamWriterOptions options) : options_(options) {}

bool StreamWriter::on_publish(const StreamMessage& message) {
  const auto found = streams_.find(message.stream);
  if (message.number < 0 || (found != streams_.end() && message.number != found->second.next())) {
    ++counts_.out_of_order;
    return false;
  }
  Stream& stream = found != streams_.end() ? found->second : streams_[message.stream];
  if (found == streams_.end()) stream.first = message.number;
  stream.messages.push_back(message.bytes);
  order_.push_back(message.stream);
  history_bytes_ += message.bytes.size();
  while (history_bytes_ > options_.history_bytes && order_.size() > 1) {
    Stream& oldest = streams_[order_.front()];
    history_bytes_ -= oldest.messages.front().size();
    oldest.messages.pop_front();
    ++oldest.first;
    order_.pop_front();
  }
  return true;
}

void StreamWriter::on_resend(const StreamGap& gap) {
  const auto found = streams_.find(gap.stream);
  if (found == streams_.end() || gap.first > gap.last) return;
  const Stream& stream = found->second;
  if (gap.first < stream.first) ++counts_.forgotten;
  const std::int32_t last = std::min(gap.last, stream.next() - 1);
  for (std::int32_t number = std::max(gap.first, stream.first); number <= last; ++number) {
    if (pending_.size() >= options_.max_pending) return;
    pending_.emplace(gap.stream, number);
  }
}

StreamWriterActions StreamWriter::on_tick(Utime now) {
  StreamWriterActions actions;
  std::size_t bytes = 0;
  while (!pending_.empty() && bytes < options_.resend_bytes_per_tick) {
    const auto [name, number] = *pending_.begin();
    pending_.erase(pending_.begin());
    const Stream& stream = streams_[name];
    if (number < stream.first) continue;  // forgotten since it was asked for
    actions.send.push_back({name, number, stream.messages[static_cast<std::size_t>(number - stream.first)]});
    bytes += actions.send.back().bytes.size();
    ++counts_.resent;
  }
  if (now >= heads_due_us_) {
    for (const auto& [name, stream] : streams_) actions.heads.push_back({name, stream.first, stream.next()});
    heads_due_us_ = now + options_.head_period_us;
  }
  return actions;
}

}  // namespace covey
