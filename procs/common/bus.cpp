// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/bus.h"

#include <spdlog/spdlog.h>

#include <deque>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <regex>
#include <vector>

#include "core/base/bands.h"
#include "core/base/error.h"
#include "procs/common/bus_streams.h"
#include "procs/common/log_file.h"

namespace covey {
namespace {

constexpr std::size_t kLongestChannel = 63;  // liblcm refuses more
constexpr int kReceiveBuffer = 4 << 20;      // with the default of 208 kB, 7 of 100 raw images arrive
constexpr Utime kStreamTickUs = 20'000;
const std::string kLogPrefix = "file://";

std::string log_path(const std::string& url) {
  const std::string path = url.substr(kLogPrefix.size());
  if (path.find('?') != std::string::npos) {
    throw_input_error("{}: a log takes no options after '?'; time comes from its events", url);
  }
  return path;
}

std::string escaped(const std::string& channel) {
  std::string regex;
  for (const char c : channel) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_') regex += '\\';
    regex += c;
  }
  return regex;
}

// A udpm URL says its receive buffer and its ttl: with liblcm's defaults large messages are lost, and ttl is
// 0 anyway.
std::string complete(std::string url) {
  if (url.rfind("udpm://", 0) != 0) return url;
  const auto append = [&url](const std::string& key, const std::string& value) {
    if (url.find(key + "=") != std::string::npos) return;
    url += (url.find('?') == std::string::npos ? "?" : "&") + key + "=" + value;
  };
  append("ttl", "0");
  append("recv_buf_size", std::to_string(kReceiveBuffer));
  return url;
}

std::unique_ptr<lcm::LCM> open_lcm(const std::string& url) {
  if (url.rfind("udpm://", 0) != 0 && url.rfind("memq://", 0) != 0) {
    throw_input_error("--url {}: expected udpm://GROUP:PORT or file://LOG.lcm", url);
  }
  auto bus = std::make_unique<lcm::LCM>(url);
  // The socket is only opened, and multicast only tried out, when the descriptor is asked for.
  if (!bus->good() || bus->getFileno() < 0) {
    throw_input_error(
        "{}: this LCM bus cannot be opened; bin/check_net says what is missing (a multicast route?)", url);
  }
  long rmem_max = kReceiveBuffer;
  std::ifstream("/proc/sys/net/core/rmem_max") >> rmem_max;
  if (rmem_max < kReceiveBuffer && url.rfind("udpm://", 0) == 0) {
    spdlog::info("receive buffers are limited to {} bytes; bin/check_net tells how to raise that", rmem_max);
  }
  return bus;
}

// A log answers nobody: what was sent again when it was recorded follows within seconds, or is not in it.
StreamReaderOptions reader_options(const std::string& url) {
  StreamReaderOptions options;
  if (is_log_url(url)) options.give_up_after = 8;  // about 7 s
  return options;
}

}  // namespace

struct Bus::Impl {
  using Handler = std::function<bool(const std::string& channel, const Bytes& bytes)>;

  struct Message {
    std::string channel;
    Bytes bytes;
  };
  struct Subscription {
    Impl* bus = nullptr;
    std::string pattern;  // a regular expression
    std::regex regex;
    Handler handler;
    QueueOptions queue;
    bool counts = true;  // streams count what they hand on instead
    FaultInjector faults;
    std::deque<Message> waiting;
  };

  Impl(const BusOptions& bus_options, EventLoop& event_loop, Status& process_status)
      : options(bus_options),
        loop(event_loop),
        status(process_status),
        streams(reader_options(options.url), status,
                [this](const std::string& channel, const Bytes& bytes) { publish(channel, bytes); }) {}

  Subscription& add(const std::string& pattern, Handler handler, QueueOptions queue, bool counts);
  Subscription& add_queue(const std::string& channel, std::function<bool(const Bytes&)> handler,
                          QueueOptions queue);
  static void on_lcm_message(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                             Subscription* subscription);
  bool publish(const std::string& channel, const Bytes& bytes);
  void on_log_event(const std::string& channel, const Bytes& bytes);
  void drain();
  void receive(Subscription& subscription, const std::string& channel, Bytes bytes);
  void enqueue(Subscription& subscription, Message message);
  void dispatch_one();
  void call(const std::string& channel, const std::function<bool()>& handler, bool counts);

  void start_streams();
  bool on_band(BandAssembler& assembler, Subscription& images, const std::string& channel,
               const Bytes& bytes);

  struct BandWriter {
    std::int64_t run = 0;
    std::int32_t next = 0;
  };

  BusOptions options;
  EventLoop& loop;
  Status& status;
  std::unique_ptr<lcm::LCM> lcm;           // none from a log
  std::deque<Subscription> subscriptions;  // references stay valid
  std::deque<Subscription> queues;         // of image sets; references stay valid
  std::deque<Subscription*> inbox;         // whose turn it is; one entry for each waiting message
  bool dispatching = false;
  bool streams_started = false;
  BusStreams streams;
  std::map<std::string, BandWriter> band_writers;
};

Bus::Bus(const BusOptions& options, EventLoop& loop, Status& status)
    : impl_(std::make_unique<Impl>(options, loop, status)) {
  if (is_log_url(options.url)) {
    loop.add_source(std::make_unique<LogReader>(
        log_path(options.url), [impl = impl_.get()](const std::string& channel, const Bytes& bytes) {
          impl->on_log_event(channel, bytes);
        }));
    return;
  }
  impl_->options.url = complete(options.url);
  impl_->lcm = open_lcm(impl_->options.url);
  loop.add_fd(impl_->lcm->getFileno(), [impl = impl_.get()] { impl->drain(); });
}

Bus::~Bus() {
  if (impl_->lcm) impl_->loop.remove_fd(impl_->lcm->getFileno());
}

const std::string& Bus::url() const { return impl_->options.url; }
bool Bus::from_log() const { return impl_->lcm == nullptr; }

void Bus::subscribe_bytes(const std::string& channel, BytesHandler handler, QueueOptions queue) {
  COVEY_CHECK(!channel.empty() && channel.size() <= kLongestChannel);
  impl_->add(
      escaped(channel),
      [handler = std::move(handler)](const std::string&, const Bytes& bytes) { return handler(bytes); },
      queue, true);
}

void Bus::subscribe_raw(const std::string& regex, RawHandler handler, QueueOptions queue) {
  impl_->add(
      regex,
      [handler = std::move(handler)](const std::string& channel, const Bytes& bytes) {
        handler(channel, bytes);
        return true;
      },
      queue, true);
}

bool Bus::publish_raw(const std::string& channel, const Bytes& bytes) {
  return impl_->publish(channel, bytes);
}

bool Bus::Impl::publish(const std::string& channel, const Bytes& bytes) {
  if (channel.empty() || channel.size() > kLongestChannel) {
    status.count("dropped/" + channel.substr(0, kLongestChannel) + "/bad_channel_name");
    return false;
  }
  if (lcm && lcm->publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) != 0) {
    status.count("dropped/" + channel + "/send_failed");
    return false;
  }
  if (options.recorder) options.recorder->write(loop.now(), channel, bytes);
  status.count("out/" + channel);
  return true;
}

Bus::Impl::Subscription& Bus::Impl::add(const std::string& pattern, Handler handler, QueueOptions queue,
                                        bool counts) {
  std::regex regex;
  try {
    regex = std::regex(pattern);
  } catch (const std::regex_error&) {
    throw_input_error("'{}' is not a regular expression for channel names", pattern);
  }
  if (queue.newest_wins && queue.capacity == 0) queue.capacity = 1;
  BusFaults faults = options.faults;
  faults.seed += subscriptions.size();  // each subscription meets its own luck
  subscriptions.push_back(
      {this, pattern, std::move(regex), std::move(handler), queue, counts, FaultInjector(faults), {}});
  Subscription& subscription = subscriptions.back();
  if (lcm) {
    lcm->subscribeFunction(pattern, &on_lcm_message, &subscription)->setQueueCapacity(0);  // 0: unlimited
  }
  return subscription;
}

// Messages that come from elsewhere than liblcm or the log.
Bus::Impl::Subscription& Bus::Impl::add_queue(const std::string& channel,
                                              std::function<bool(const Bytes&)> handler, QueueOptions queue) {
  if (queue.newest_wins && queue.capacity == 0) queue.capacity = 1;
  const auto on_message = [handler = std::move(handler)](const std::string&, const Bytes& bytes) {
    return handler(bytes);
  };
  queues.push_back({this, channel, {}, on_message, queue, true, FaultInjector({}), {}});
  return queues.back();
}

// Called from C: nothing may be thrown from here.
void Bus::Impl::on_lcm_message(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                               Subscription* subscription) {
  try {
    const auto* data = static_cast<const std::uint8_t*>(buffer->data);
    subscription->bus->receive(*subscription, channel, Bytes(data, data + buffer->data_size));
  } catch (const std::exception&) {
    subscription->bus->status.count("dropped/" + channel.substr(0, kLongestChannel) + "/no_memory");
  }
}

void Bus::Impl::on_log_event(const std::string& channel, const Bytes& bytes) {
  for (std::size_t i = 0; i < subscriptions.size(); ++i) {
    if (std::regex_match(channel, subscriptions[i].regex)) receive(subscriptions[i], channel, bytes);
  }
}

void Bus::Impl::drain() {
  constexpr int kAtOnce = 1000;  // then timers and signals get their turn
  for (int i = 0; i < kAtOnce && lcm->handleTimeout(0) > 0; ++i) {
  }
}

void Bus::Impl::receive(Subscription& subscription, const std::string& channel, Bytes bytes) {
  if (!subscription.faults.faults().any()) {
    enqueue(subscription, {channel, std::move(bytes)});
    return;
  }
  for (const Utime delay : subscription.faults.next(channel)) {
    loop.call_at(loop.now() + delay, [this, &subscription, channel, bytes] {
      enqueue(subscription, {channel, bytes});
    });
  }
}

void Bus::Impl::enqueue(Subscription& subscription, Message message) {
  const QueueOptions& queue = subscription.queue;
  const bool full = queue.capacity > 0 && subscription.waiting.size() >= queue.capacity;
  if (full) status.count("dropped/" + message.channel + "/queue_full");
  if (full && !queue.newest_wins) return;
  if (full) {
    subscription.waiting.pop_front();  // its turn goes to the next of the same subscription
  } else {
    inbox.push_back(&subscription);
  }
  subscription.waiting.push_back(std::move(message));
  if (!std::exchange(dispatching, true)) loop.post([this] { dispatch_one(); });
}

// One message a turn of the loop: what arrives during a slow handler is sorted into the queues before the
// next one is taken.
void Bus::Impl::dispatch_one() {
  Subscription& subscription = *inbox.front();
  inbox.pop_front();
  const Message message = std::move(subscription.waiting.front());
  subscription.waiting.pop_front();
  dispatching = !inbox.empty();
  if (dispatching) loop.post([this] { dispatch_one(); });
  call(
      message.channel, [&] { return subscription.handler(message.channel, message.bytes); },
      subscription.counts);
}

void Bus::Impl::call(const std::string& channel, const std::function<bool()>& handler, bool counts) {
  try {
    if (!handler()) {
      status.count("dropped/" + channel + "/undecodable");
    } else if (counts) {
      status.count("in/" + channel);
    }
  } catch (const std::exception& error) {
    status.count("bugs/" + channel);
    spdlog::error("a handler of {} threw: {}", channel, error.what());
  }
}

void Bus::subscribe_stream(const std::string& channel, NumberOf number_of, BytesHandler handler,
                           const StreamPositions& have) {
  COVEY_CHECK(!channel.empty() && channel.size() <= kLongestChannel);
  impl_->start_streams();
  auto deliver = [impl = impl_.get(), channel, handler = std::move(handler)](const Bytes& bytes) {
    impl->call(
        channel, [&] { return handler(bytes); }, true);
  };
  BusStreams::Reader& reader = impl_->streams.add_reader(channel, have, std::move(deliver));
  const auto on_message = [impl = impl_.get(), &reader, number_of = std::move(number_of)](
                              const std::string&, const Bytes& bytes) {
    StreamMessage message;
    if (!number_of(bytes, message)) return false;
    message.bytes = bytes;
    impl->streams.on_message(reader, std::move(message), impl->loop.now());
    return true;
  };
  impl_->add(escaped(channel), on_message, {}, false);
}

void Bus::publish_stream(const std::string& channel, const StreamMessage& message) {
  impl_->start_streams();
  impl_->streams.on_publish(channel, message);
  publish_raw(channel, message.bytes);
}

// The messages that repair streams are only listened to where there are any.
void Bus::Impl::start_streams() {
  if (std::exchange(streams_started, true)) return;
  const auto on_head = [this](const std::string&, const Bytes& bytes) {
    stream_head_t head{};
    if (!decode(bytes, head)) return false;
    streams.on_head(head, loop.now());
    return true;
  };
  const auto on_resend = [this](const std::string&, const Bytes& bytes) {
    resend_t resend{};
    if (!decode(bytes, resend)) return false;
    streams.on_resend(resend);
    return true;
  };
  add(escaped(kStreamHead.name), on_head, {}, true);
  add(escaped(kResend.name), on_resend, {}, true);
  loop.call_every(kStreamTickUs, [this] { streams.on_tick(loop.now()); });
}

// Every band is put in its place at once; whole image sets then queue like any other message.
void Bus::subscribe_bands(const std::string& channel, BytesHandler handler, QueueOptions queue) {
  COVEY_CHECK(!channel.empty() && channel.size() <= kLongestChannel);
  Impl::Subscription& images = impl_->add_queue(channel, std::move(handler), queue);
  const auto assembler = std::make_shared<BandAssembler>();
  const auto on_band = [impl = impl_.get(), assembler, &images](const std::string& name, const Bytes& bytes) {
    return impl->on_band(*assembler, images, name, bytes);
  };
  impl_->add(escaped(channel), on_band, {}, false);
}

bool Bus::Impl::on_band(BandAssembler& assembler, Subscription& images, const std::string& channel,
                        const Bytes& bytes) {
  band_t band{};
  if (!decode(bytes, band)) return false;
  BandAssembler::Result result = assembler.add(std::move(band));
  if (!result.dropped.empty()) status.count(fmt::format("dropped/{}/{}", channel, result.dropped));
  if (result.incomplete + result.missing > 0)
    status.count("lost/" + channel, result.incomplete + result.missing);
  if (result.message) enqueue(images, {channel, std::move(*result.message)});
  return true;
}

void Bus::publish_bands(const std::string& channel, Utime utime, const Bytes& bytes) {
  Impl::BandWriter& writer = impl_->band_writers[channel];
  if (writer.run == 0) writer.run = impl_->loop.now();
  Utime due = impl_->loop.now();
  for (const band_t& band : split_bands(bytes, utime, writer.run, writer.next)) {
    if (band.band == 0) {
      publish_raw(channel, encode(band));
    } else {
      impl_->loop.call_at(due += kBandSpacingUs,
                          [this, channel, encoded = encode(band)] { publish_raw(channel, encoded); });
    }
  }
  ++writer.next;
}

bool is_log_url(const std::string& url) { return url.rfind(kLogPrefix, 0) == 0; }

std::string robot_bus_url(int robot) {
  return complete(fmt::format("udpm://239.255.76.67:{}", 7700 + robot));
}
std::string sensor_bus_url(int robot) {
  return complete(fmt::format("udpm://239.255.76.67:{}", 7720 + robot));
}
std::string depth_bus_url(int robot) {
  return complete(fmt::format("udpm://239.255.76.67:{}", 7740 + robot));
}

}  // namespace covey
