// Pages opened from disk may not start a worker: there the search runs in a hidden frame instead.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.frame = frame;
      this.inner = frame.contentWindow;
      this.ready = new Promise((done) => { frame.onload = done; });
      this.heard = (event) => {
        if (event.source !== this.inner) return;
        const answer = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(answer);
        if (this.onmessage) this.onmessage(answer);
      };
      addEventListener("message", this.heard);
      const page = this.inner.document;
      page.open();
      page.write(
        "<script>postMessage = (data) => parent.dispatchEvent(new MessageEvent('message', " +
        "{ data, source: window })); importScripts = (...urls) => Promise.all(urls.map((url) => " +
        "new Promise((done) => { const one = document.createElement('script'); one.src = url; " +
        "one.onload = done; document.body.append(one); })));</" + "script>" +
        `<script src="${url}"></` + "script>"
      );
      page.close();
    }
    postMessage(data) {
      this.ready.then(() => this.inner.dispatchEvent(new MessageEvent("message", { data })));
    }
    terminate() {
      removeEventListener("message", this.heard);
      this.frame.remove();
    }
  };
}
