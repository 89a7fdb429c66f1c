// Work on the newest of what comes, in a node whose work may take longer than the next takes to come.
#pragma once

#include <ros/callback_queue.h>

#include <boost/make_shared.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace safe_passage {

// Another thread puts work in, the thread of the node's callbacks does it. What was not begun when
// newer work comes is dropped: its result would be old, and everything behind it late.
class NewestWork {
 public:
  using Work = std::function<void()>;

  // `dropped` is called for each that is dropped, in the thread that puts in.
  explicit NewestWork(Work dropped) : dropped_(std::move(dropped)) {}

  void put(Work work) {
    std::unique_lock<std::mutex> lock(waiting_->mutex);
    std::swap(waiting_->work, work);
    lock.unlock();
    if (work)
      dropped_();
    else
      ros::getGlobalCallbackQueue()->addCallback(boost::make_shared<Turn>(waiting_));
  }

 private:
  struct Waiting {
    std::mutex mutex;
    Work work;  // empty: none
  };

  struct Turn : ros::CallbackInterface {
    explicit Turn(std::shared_ptr<Waiting> of) : waiting(std::move(of)) {}

    CallResult call() override {
      std::unique_lock<std::mutex> lock(waiting->mutex);
      const Work work = std::exchange(waiting->work, nullptr);
      lock.unlock();
      if (work) work();
      return Success;
    }

    std::shared_ptr<Waiting> waiting;
  };

  const Work dropped_;
  const std::shared_ptr<Waiting> waiting_ = std::make_shared<Waiting>();
};

}  // namespace safe_passage
