// What a Go program does beside its lines: it collects garbage while goroutines compute, starts a child, takes a signal. What
// it has done is told on a serial line.
package main

import (
	"fmt"
	"math/rand"
	"os"
	"os/exec"
	"os/signal"
	"runtime"
	"sync"
	"syscall"
	"time"
)

var kept [64][]byte

func main() {
	out, err := os.OpenFile("/dev/ttyHIL0", os.O_RDWR, 0)
	if err != nil {
		os.Exit(3)
	}
	start := time.Now()
	tell := func(words ...any) { fmt.Fprintln(out, append(words, time.Since(start))...) }
	var group sync.WaitGroup
	var mutex sync.Mutex
	order := ""
	for worker := 0; worker < 4; worker++ {
		group.Add(1)
		go func(worker int) {
			defer group.Done()
			for round := 0; round < 50; round++ {
				for place := range kept {
					mutex.Lock()
					kept[place] = make([]byte, 1<<14)
					mutex.Unlock()
				}
				runtime.Gosched()
				if round%10 == 0 {
					mutex.Lock()
					order += fmt.Sprint(worker)
					mutex.Unlock()
					time.Sleep(time.Duration(worker+1) * time.Millisecond)
				}
			}
		}(worker)
	}
	group.Wait()
	var state runtime.MemStats
	runtime.ReadMemStats(&state)
	tell("processors", runtime.NumCPU(), "collected", state.NumGC > 5, "order", order)
	said, err := exec.Command("sh", "-c", "sleep 0.25; echo child").Output()
	tell("child", string(said[:5]), err)
	// A loop that calls nothing is stopped by a signal of the runtime's own alone.
	done := make(chan bool)
	go func() {
		sum := 0
		for sum < 100_000_000 {
			sum++
		}
		done <- sum > 0
	}()
	runtime.GC()
	<-done
	tell("computed", rand.New(rand.NewSource(7)).Intn(100))
	signals := make(chan os.Signal, 1)
	signal.Notify(signals, syscall.SIGTERM, syscall.SIGALRM)
	syscall.Kill(os.Getpid(), syscall.SIGALRM)
	tell(<-signals)
	tell(<-signals)
}
