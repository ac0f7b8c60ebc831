; How the threads of this process share the pieces of a loop: see loop_sharing.py. For Linux on x86-64.
target triple = "x86_64-unknown-linux-gnu"

@workers = global i32 0, align 64  ; how many threads help
@loops = global i32 0, align 64    ; how many loops were shared so far; a worker sleeps until it changes
@open = global i32 0, align 64     ; 1 while workers may take pieces of the loop
@inside = global i32 0, align 64   ; workers that may be taking pieces
@waiting = global i32 0, align 64  ; 1 while the caller sleeps until nobody is inside
@taken = global i32 0, align 64    ; 1 while a loop is shared; another caller then does its own loop alone
@next = global i32 0, align 64     ; the piece that is to be done next

@pieces = global i32 0, align 64   ; the loop that is shared; written only while it is closed and nobody is inside
@context = global i8* null
@piece = global void (i8*, i32, i32)* null

@control = global i32 8064         ; the thread that called `prepare` computes so: how it rounds, and what it does with tiny numbers
@was_long = global [1024 x i8] zeroinitializer  ; by kernel and number of pieces: 1 if it took long the last time

declare i64 @syscall(i64, ...)
declare i64 @llvm.readcyclecounter()
declare i32 @llvm.smin.i32(i32, i32)
declare void @llvm.x86.sse2.pause()
declare void @llvm.x86.sse.stmxcsr(i8*)
declare void @llvm.x86.sse.ldmxcsr(i8*)

; Sleep until the word at an address differs from what was seen there. It may wake earlier.
define internal void @sleep_while(i32* %word, i32 %seen) {
  %result = call i64 (i64, ...) @syscall(i64 202, i32* %word, i32 128, i32 %seen, i8* null, i8* null, i32 0)
  ret void
}

; Wake up to `count` threads that sleep on the word at an address.
define internal void @wake(i32* %word, i32 %count) {
  %result = call i64 (i64, ...) @syscall(i64 202, i32* %word, i32 129, i32 %count, i8* null, i8* null, i32 0)
  ret void
}

; Take piece after piece of the loop until none is left.
define internal void @take_pieces(i8* %context, void (i8*, i32, i32)* %piece, i32 %pieces, i32 %thread) {
entry:
  br label %take
take:
  %k = atomicrmw add i32* @next, i32 1 seq_cst
  %is_left = icmp slt i32 %k, %pieces
  br i1 %is_left, label %do, label %end
do:
  call void %piece(i8* %context, i32 %thread, i32 %k)
  br label %take
end:
  ret void
}

; Let all threads compute as the calling one does, whoever takes a piece.
define void @prepare() {
  call void @llvm.x86.sse.stmxcsr(i8* bitcast (i32* @control to i8*))
  ret void
}

; Run a loop: piece(context, thread, k) for each k below `pieces`. Called by the thread that launches a kernel, in place of
; Taichi's function, which has the same arguments.
define void @run(i8* %pool, i32 %pieces, i32 %threads, i8* %context, void (i8*, i32, i32)* %piece) {
entry:
  %own = alloca i32
  %own_control = bitcast i32* %own to i8*
  call void @llvm.x86.sse.stmxcsr(i8* %own_control)
  call void @llvm.x86.sse.ldmxcsr(i8* bitcast (i32* @control to i8*))
  %began = call i64 @llvm.readcyclecounter()
  %workers = load atomic i32, i32* @workers seq_cst, align 4
  %has_none = icmp eq i32 %workers, 0
  %at_first = select i1 %has_none, i64 -1, i64 20000  ; cycles of work after which it is worth waking others
  %address = ptrtoint void (i8*, i32, i32)* %piece to i64
  %kernel = lshr i64 %address, 4
  %number = zext i32 %pieces to i64
  %mixed = mul i64 %number, 40503
  %both = add i64 %kernel, %mixed
  %place = and i64 %both, 1023
  %known = getelementptr [1024 x i8], [1024 x i8]* @was_long, i64 0, i64 %place
  %flag = load atomic i8, i8* %known monotonic, align 1
  %is_long = icmp ne i8 %flag, 0
  %is_several = icmp sgt i32 %pieces, 1
  %is_worth_it = and i1 %is_long, %is_several
  %at_once = select i1 %has_none, i1 false, i1 %is_worth_it
  br i1 %at_once, label %share, label %alone

alone:  ; the calling thread does its loop alone
  %k = phi i32 [ 0, %entry ], [ %done, %after ], [ %first, %share ]
  %limit = phi i64 [ %at_first, %entry ], [ %limit, %after ], [ -1, %share ]
  %is_left = icmp slt i32 %k, %pieces
  br i1 %is_left, label %do, label %learn_alone
do:
  call void %piece(i8* %context, i32 0, i32 %k)
  br label %after
after:
  %done = add i32 %k, 1
  %left = sub i32 %pieces, %done
  %now = call i64 @llvm.readcyclecounter()
  %spent = sub i64 %now, %began
  %is_short = icmp ult i64 %spent, %limit
  %is_last = icmp sle i32 %left, 1
  %goes_on = or i1 %is_short, %is_last
  br i1 %goes_on, label %alone, label %share
learn_alone:  ; is the loop worth sharing from its beginning? it takes about 100,000 cycles until others help
  %end_alone = call i64 @llvm.readcyclecounter()
  %spent_alone = sub i64 %end_alone, %began
  %was_long_alone = icmp ugt i64 %spent_alone, 150000
  %flag_alone = zext i1 %was_long_alone to i8
  store atomic i8 %flag_alone, i8* %known monotonic, align 1
  br label %end

share:
  %first = phi i32 [ 0, %entry ], [ %done, %after ]
  %was_taken = atomicrmw xchg i32* @taken, i32 1 seq_cst
  %is_free = icmp eq i32 %was_taken, 0
  br i1 %is_free, label %publish, label %alone
publish:
  store i8* %context, i8** @context
  store void (i8*, i32, i32)* %piece, void (i8*, i32, i32)** @piece
  store i32 %pieces, i32* @pieces
  store atomic i32 %first, i32* @next seq_cst, align 4
  store atomic i32 1, i32* @open seq_cst, align 4
  %before = atomicrmw add i32* @loops, i32 1 seq_cst
  %rest = sub i32 %pieces, %first
  %others = sub i32 %rest, 1
  %useful = call i32 @llvm.smin.i32(i32 %workers, i32 %others)
  call void @wake(i32* @loops, i32 %useful)
  call void @take_pieces(i8* %context, void (i8*, i32, i32)* %piece, i32 %pieces, i32 0)
  store atomic i32 0, i32* @open seq_cst, align 4
  br label %look

look:  ; until nobody is inside: for a while awake, as the last piece of a worker is mostly a short one
  %looks = phi i32 [ 0, %publish ], [ %looked, %again ]
  %inside = load atomic i32, i32* @inside seq_cst, align 4
  %is_empty = icmp eq i32 %inside, 0
  br i1 %is_empty, label %free, label %again
again:
  call void @llvm.x86.sse2.pause()
  %looked = add i32 %looks, 1
  %has_patience = icmp ult i32 %looked, 1000
  br i1 %has_patience, label %look, label %fall_asleep
fall_asleep:
  store atomic i32 1, i32* @waiting seq_cst, align 4
  br label %asleep
asleep:
  %still_inside = load atomic i32, i32* @inside seq_cst, align 4
  %is_empty_now = icmp eq i32 %still_inside, 0
  br i1 %is_empty_now, label %awake, label %sleep
sleep:
  call void @sleep_while(i32* @inside, i32 %still_inside)
  br label %asleep
awake:
  store atomic i32 0, i32* @waiting seq_cst, align 4
  br label %free
free:
  store atomic i32 0, i32* @taken seq_cst, align 4
  %end_shared = call i64 @llvm.readcyclecounter()
  %spent_shared = sub i64 %end_shared, %began
  %was_long_shared = icmp ugt i64 %spent_shared, 75000  ; half of the limit above: two or more have shared the work
  %flag_shared = zext i1 %was_long_shared to i8
  store atomic i8 %flag_shared, i8* %known monotonic, align 1
  br label %end
end:
  call void @llvm.x86.sse.ldmxcsr(i8* %own_control)
  ret void
}

; The life of a worker: help with each loop that is shared. It ends when there are to be no workers.
define void @help(i32 %thread) {
entry:
  call void @llvm.x86.sse.ldmxcsr(i8* bitcast (i32* @control to i8*))
  br label %rest

rest:
  %seen = phi i32 [ 0, %entry ], [ %seen, %sleep ], [ %latest, %leave ], [ %latest, %tell ]
  %workers = load atomic i32, i32* @workers seq_cst, align 4
  %is_over = icmp eq i32 %workers, 0
  br i1 %is_over, label %end, label %watch
watch:
  %latest = load atomic i32, i32* @loops seq_cst, align 4
  %is_old = icmp eq i32 %latest, %seen
  br i1 %is_old, label %sleep, label %enter
sleep:
  call void @sleep_while(i32* @loops, i32 %seen)
  br label %rest

enter:  ; first say that it is inside, then look: whoever closes the loop does these two the other way round
  %others = atomicrmw add i32* @inside, i32 1 seq_cst
  %is_open = load atomic i32, i32* @open seq_cst, align 4
  %is_closed = icmp eq i32 %is_open, 0
  br i1 %is_closed, label %leave, label %take
take:
  %context = load i8*, i8** @context
  %piece = load void (i8*, i32, i32)*, void (i8*, i32, i32)** @piece
  %pieces = load i32, i32* @pieces
  call void @take_pieces(i8* %context, void (i8*, i32, i32)* %piece, i32 %pieces, i32 %thread)
  br label %leave
leave:
  %were_inside = atomicrmw sub i32* @inside, i32 1 seq_cst
  %is_waited_for = load atomic i32, i32* @waiting seq_cst, align 4
  %nobody_waits = icmp eq i32 %is_waited_for, 0
  br i1 %nobody_waits, label %rest, label %tell
tell:
  call void @wake(i32* @inside, i32 1)
  br label %rest
end:
  ret void
}

; End the lives of all workers.
define void @stop() {
  store atomic i32 0, i32* @workers seq_cst, align 4
  %before = atomicrmw add i32* @loops, i32 1 seq_cst
  call void @wake(i32* @loops, i32 2147483647)
  ret void
}
